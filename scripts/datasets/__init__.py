"""What makes data sets, and the virtual tank behind them."""
