run no_scenario.json
