// Toggles the clock of a design that Yosys made C++ of: PROGRAM CYCLES [TRACE]. One cycle of reset comes before.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "design.cc"
#if TRACE_VCD
#include <cxxrtl/cxxrtl_vcd.h>
#endif

int main(int argc, char **argv) {
  const unsigned long long cycles = strtoull(argv[1], nullptr, 10);
  cxxrtl_design::TOP design;
#if TRACE_VCD
  cxxrtl::debug_items items;
  design.debug_info(&items, nullptr, "");
  cxxrtl::vcd_writer trace;
  trace.timescale(1, "ns");
  trace.add_without_memories(items);
  std::ofstream file(argv[2], std::ios::binary);
  auto dump = [&](uint64_t t) {
    trace.sample(t);
    if (trace.buffer.size() > 1 << 16) {
      file.write(trace.buffer.data(), trace.buffer.size());
      trace.buffer.clear();
    }
  };
#else
  auto dump = [](uint64_t) {};
#endif
  uint64_t t = 0;
  design.p_rst.set<bool>(true);
  design.p_clk.set<bool>(false);
  design.step();
  dump(t);
  for (unsigned long long n = 0; n <= cycles; n++) {
    design.p_clk.set<bool>(true);
    design.step();
    dump(++t);
    design.p_clk.set<bool>(false);
    design.p_rst.set<bool>(false);
    design.step();
    dump(++t);
  }
#if TRACE_VCD
  file.write(trace.buffer.data(), trace.buffer.size());
  file.close();
#endif
  printf("checksum=%08x\n", design.p_checksum.get<unsigned>());
}
