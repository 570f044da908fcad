/* Functions that differ between QEMU and a real board: text output, exit, and counting of instructions. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

void board_print(const char* text);
void board_print_number(uint32_t value);
__attribute__((noreturn)) void board_exit(int status);

/* Instructions since board_start_counting(), up to 600 millions, in steps of 40. Under `qemu -icount shift=0`
 * an instruction takes 1 ns of simulated time, and SysTick counts at 25 MHz. */
void board_start_counting(void);
uint32_t board_instructions(void);

/* Bytes of stack that functions called between the two calls have used, at most 16 kB. */
void board_mark_stack(void);
uint32_t board_used_stack(void);

#endif
