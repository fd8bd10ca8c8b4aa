"""Record, measure and plot simulations."""
