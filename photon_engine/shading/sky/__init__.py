"""Models of the clear sky: Preetham, Hosek and Wilkie, single and multiple scattering."""
