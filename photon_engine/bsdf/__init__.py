"""How surfaces scatter light: one law a file, and Principled as a recipe of lobes."""
