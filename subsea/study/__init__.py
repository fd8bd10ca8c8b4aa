"""Records of simulations: made, measured, plotted."""
