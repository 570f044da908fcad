/* Start-up code: vectors, floating-point unit, initial data. It also has the three functions that compilers call
 * for loops over bytes, so that no C library is needed. */
#include <stddef.h>
#include <stdint.h>

#include "board.h"

extern unsigned char data_begin[], data_end[], data_in_flash[], bss_begin[], bss_end[], stack_top[];
int main(void);

#define CPACR (*(volatile uint32_t*)0xE000ED88)

/* For loops that the compiler must not replace by recursive calls. */
#define PLAIN __attribute__((optimize("no-tree-loop-distribute-patterns")))

PLAIN void* memcpy(void* restrict to, const void* restrict from, size_t n) {
  unsigned char* t = to;
  const unsigned char* f = from;
  while (n-- > 0) *t++ = *f++;
  return to;
}

PLAIN void* memset(void* to, int value, size_t n) {
  unsigned char* t = to;
  while (n-- > 0) *t++ = (unsigned char)value;
  return to;
}

PLAIN void* memmove(void* to, const void* from, size_t n) {
  unsigned char* t = to;
  const unsigned char* f = from;
  if (t < f) return memcpy(to, from, n);
  while (n-- > 0) t[n] = f[n];
  return to;
}

/* No instruction before this point may use the floating-point unit. */
__attribute__((noreturn, target("general-regs-only"))) void reset(void) {
  CPACR |= 0xFu << 20;
  __asm volatile("dsb\n isb" ::: "memory");
  memcpy(data_begin, data_in_flash, (size_t)(data_end - data_begin));
  memset(bss_begin, 0, (size_t)(bss_end - bss_begin));
  board_exit(main());
}

static void fault(void) {
  board_print("fault\n");
  board_exit(3);
}

#define FIVE_FAULTS fault, fault, fault, fault, fault
__attribute__((section(".vectors"), used)) static void (*const vectors[])(void) = {
    (void (*)(void))stack_top, reset, FIVE_FAULTS, 0, 0, 0, 0, fault, fault, 0, fault, fault};
