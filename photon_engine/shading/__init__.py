"""Node graphs to programs, one pure function a node, evaluated on batches of hits."""
