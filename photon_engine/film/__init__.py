"""Pass registry, accumulation over passes, merging, and pictures on disk."""
