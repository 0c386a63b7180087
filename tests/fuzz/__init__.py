"""Malformed scene files and settings: whatever they hold, the answer is a picture or a message, never a crash.

`python -m tests.fuzz COUNT [SEED] [SCENE.npz]` tries COUNT files in a process of its own and says which broke it.
"""
