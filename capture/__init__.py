"""The offline tool that swims the simulated fish and records what it does (SMC §4)."""
