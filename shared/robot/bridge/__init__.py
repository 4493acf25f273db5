"""What all bridges to robots share: commands on their way there, the state on its way back, and the watch over it."""
