run yosys_parameter.json -p W=3 --time 5
