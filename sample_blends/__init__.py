"""The sample scenes, the scripts that build them, and their reference pictures."""
