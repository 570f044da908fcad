/* The header is C; the installed library links from C; a text that is no model is refused in words. */
#include <phynness/phynness.h>
#include <stdio.h>

int main(void) {
  size_t bytes = 1;
  const int status = phn_model_size("hello", 5, &bytes);
  printf("phynness %s: %s\n", phn_version(), phn_status_message(status));
  return status == PHN_ERROR_NOT_A_MODEL && bytes == 0 ? 0 : 1;
}
