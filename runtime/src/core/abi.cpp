// Version and sizes of structures, which bindings compare with their own headers.
#include <phynness/phynness_contact.h>
#include <phynness/phynness_image.h>
#include <phynness/phynness_loop.h>
#include <phynness/phynness_surface.h>
#include <phynness/phynness_tools.h>

#include <cstring>

#include "core/arithmetic.hpp"

namespace {

struct Size {
  const char* name;
  int32_t bytes;
};
constexpr Size sizes[] = {
    {"phn_provenance", sizeof(phn_provenance)},
    {"phn_relaxation", sizeof(phn_relaxation)},
    {"phn_relaxing", sizeof(phn_relaxing)},
    {"phn_info", sizeof(phn_info)},
    {"phn_tool", sizeof(phn_tool)},
    {"phn_level", sizeof(phn_level)},
    {"phn_coupled", sizeof(phn_coupled)},
    {"phn_body_contents", sizeof(phn_body_contents)},
    {"phn_body_report", sizeof(phn_body_report)},
    {"phn_contact_tool", sizeof(phn_contact_tool)},
    {"phn_contact_state", sizeof(phn_contact_state)},
    {"phn_contact_report", sizeof(phn_contact_report)},
    {"phn_surface_contents", sizeof(phn_surface_contents)},
    {"phn_loop_settings", sizeof(phn_loop_settings)},
    {"phn_loop_response", sizeof(phn_loop_response)},
    {"phn_loop_report", sizeof(phn_loop_report)},
    {"phn_bridge", sizeof(phn_bridge)},
    {"phn_image_contents", sizeof(phn_image_contents)},
    {"phn_imagef_contents", sizeof(phn_image_contents)},
    {"phn_image_tool", sizeof(phn_image_tool)},
    {"phn_imagef_tool", 6 * sizeof(float) + 4 * sizeof(int32_t)},
};

}  // namespace

extern "C" {

int32_t phn_abi_version(void) { return PHN_ABI_VERSION; }

int32_t phn_sizeof(const char* struct_name) {
  for (const Size& size : sizes)
    if (struct_name != nullptr && std::strcmp(struct_name, size.name) == 0) return size.bytes;
  return 0;
}

}  // extern "C"
