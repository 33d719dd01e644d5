run oscillating_clocks.json
