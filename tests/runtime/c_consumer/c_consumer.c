/* The headers are C; the installed libraries link from C; a text or image that is no model is refused in
 * words. */
#include <phynness/contact.h>
#include <phynness/image.h>
#include <phynness/phynness.h>
#include <stdio.h>

#ifndef PRECISION
#define PRECISION 64
#endif

int main(void) {
  size_t bytes = 1, of_contact = 1;
  const double words[] = {1, 2, 3};
  const phn_image* image = NULL;
  const int status = phn_model_size("hello", 5, &bytes),
            of_image = phn_image_open(words, sizeof words, &image);
  if (phn_contact_size(NULL, 1, &of_contact) != PHN_ERROR_ARGUMENT || of_contact != 0) return 1;
  if (phn_precision() != PRECISION) return 1;
  printf("phynness %s: %s\n", phn_version(), phn_status_message(status));
  return status == PHN_ERROR_NOT_A_MODEL && bytes == 0 && of_image == PHN_ERROR_NOT_A_MODEL && image == NULL
             ? 0
             : 1;
}
