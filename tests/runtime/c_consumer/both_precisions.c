/* One program, both libraries: each file has the names of the one that it is compiled for. */
#include <phynness/phynness.h>

#ifdef PHYNNESS_FLOAT
int bits_in_float(void) {
#else
int bits_in_double(void) {
#endif
  phn_info info;
  phn_model_info(NULL, &info);
  return (int)info.precision_bits;
}
