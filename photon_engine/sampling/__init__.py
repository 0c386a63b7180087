"""Counter-based random numbers, warps with their densities, tables and MIS weights."""
