/* Semihosting: services of a debugger or of QEMU that the instruction BKPT 0xAB calls. */
#include "board.h"

#define SYST_CSR (*(volatile uint32_t*)0xE000E010)
#define SYST_RVR (*(volatile uint32_t*)0xE000E014)
#define SYST_CVR (*(volatile uint32_t*)0xE000E018)

enum { sys_write0 = 0x04, sys_exit_extended = 0x20, stopped_application_exit = 0x20026 };

static uint32_t semihosting(uint32_t operation, const void* argument) {
  register uint32_t r0 __asm("r0") = operation;
  register const void* r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

void board_print(const char* text) { semihosting(sys_write0, text); }

void board_print_number(uint32_t value) {
  char text[11];
  char* at = text + sizeof text - 1;
  *at = 0;
  do {
    *--at = (char)('0' + value % 10);
    value /= 10;
  } while (value > 0);
  board_print(at);
}

void board_exit(int status) {
  const uint32_t argument[2] = {stopped_application_exit, (uint32_t)status};
  semihosting(sys_exit_extended, argument);
  for (;;) {
  }
}

void board_start_counting(void) {
  SYST_RVR = 0xFFFFFF;
  SYST_CVR = 0;
  SYST_CSR = 5; /* the processor's clock, no interrupt */
  while (SYST_CVR == 0) {
  } /* 0 until the first tick */
}

/* Words below the stack pointer get a pattern, of which those that no call has overwritten are left. */
enum { marked_words = 4096, left_words = 16 };
static volatile uint32_t* marked_end;

void board_mark_stack(void) {
  register uint32_t* top __asm("sp");
  marked_end = top - left_words;
  for (uint32_t i = 1; i <= marked_words; ++i) marked_end[-(int32_t)i] = 0xa5a5a5a5;
}

uint32_t board_used_stack(void) {
  uint32_t n = marked_words;
  while (n > 0 && marked_end[-(int32_t)n] == 0xa5a5a5a5) --n;
  return 4 * (n + left_words);
}

uint32_t board_instructions(void) { return 40 * (0xFFFFFF - SYST_CVR); }
