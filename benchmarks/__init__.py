"""Speed as ratios measured in one run; see run.py."""
