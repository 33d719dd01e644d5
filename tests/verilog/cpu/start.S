# Clears the registers and what has no value of its own, calls main, and ends with what it returns.
  .section .start
  .globl start
start:
  .irp n, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31
  li x\n, 0
  .endr
  la sp, stack
  la t0, bss
  la t1, bss_end
1: bgeu t0, t1, 2f
  sw zero, 0(t0)
  addi t0, t0, 4
  j 1b
2: call main
  li t0, 0x10000004
  sw a0, 0(t0)
3: j 3b
