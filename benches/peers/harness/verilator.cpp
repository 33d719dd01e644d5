// Toggles the clock of a design that Verilator translated: PROGRAM CYCLES [TRACE]. One cycle of reset comes before.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "Vdesign.h"
#include "verilated.h"
#if TRACE_FST
#include "verilated_fst_c.h"
using Trace = VerilatedFstC;
#elif TRACE_VCD
#include "verilated_vcd_c.h"
using Trace = VerilatedVcdC;
#endif

int main(int argc, char **argv) {
  const unsigned long long cycles = strtoull(argv[1], nullptr, 10);
  const auto context = std::make_unique<VerilatedContext>();
#if TRACE_FST || TRACE_VCD
  context->traceEverOn(true);
#endif
  const auto design = std::make_unique<Vdesign>(context.get());
#if TRACE_FST || TRACE_VCD
  Trace trace;
  design->trace(&trace, 99);
  trace.open(argv[2]);
#define DUMP(t) trace.dump(t)
#else
#define DUMP(t)
#endif
  uint64_t t = 0;
  design->rst = 1;
  design->clk = 0;
  design->eval();
  DUMP(t);
  for (unsigned long long n = 0; n <= cycles; n++) {
    design->clk = 1;
    design->eval();
    t++;
    DUMP(t);
    design->clk = 0;
    design->rst = 0;
    design->eval();
    t++;
    DUMP(t);
  }
#if TRACE_FST || TRACE_VCD
  trace.close();
#endif
  printf("checksum=%08x\n", design->checksum);
  design->final();
}
