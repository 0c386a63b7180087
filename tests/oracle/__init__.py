"""The oracle: converged Cycles with every shortcut switched off, and the comparison with it."""
