run no_modules.json
