run expectation_fails.json
