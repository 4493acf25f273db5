"""What every robot process keeps of the contract, looked at from outside: simulated, a bridge, or a stranger's."""
