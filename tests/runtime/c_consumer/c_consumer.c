/* The headers are C; the installed libraries link from C; a text or image that is no model is refused in words. */
#include <phynness/phynness.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_image.h>
#include <phynness/phynness_surface.h>
#include <stdio.h>

int main(void) {
  size_t bytes = 1, of_contact = 1, wrong_byte = 0;
  const double words[] = {1, 2, 3};
  const phn_image* image = NULL;
  phn_info info;
  const int status = phn_model_size("hello", 5, &bytes, &wrong_byte),
            of_image = phn_image_open(words, sizeof words, &image);
  if (phn_contact_size(NULL, 1, &of_contact) != PHN_ERROR_ARGUMENT || of_contact != 0) return 1;
  if (phn_model_info(NULL, &info) != PHN_ERROR_ARGUMENT) return 1;
  printf("phynness %s: %s\n", phn_version(), phn_status_message(status));
  return status == PHN_ERROR_NOT_A_MODEL && bytes == 0 && wrong_byte == 1 && of_image == PHN_ERROR_NOT_A_MODEL &&
                 image == NULL
             ? 0
             : 1;
}
