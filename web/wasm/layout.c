/* Sizes of the structs of the C interface and offsets of their members in 32-bit memory, by name, for JavaScript. */
#include <phynness/phynness_body.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_levels.h>
#include <stddef.h>

typedef struct entry {
  const char* name;
  int32_t bytes;
} entry;

#define SIZE(type) \
  { #type, (int32_t)sizeof(type) }
#define MEMBER(type, member) \
  { #type "." #member, (int32_t)offsetof(type, member) }

/* clang-format off */
static const entry entries[] = {
    SIZE(phn_info), MEMBER(phn_info, family), MEMBER(phn_info, title), MEMBER(phn_info, mesh_hash),
    MEMBER(phn_info, max_displacement_m), MEMBER(phn_info, active_nodes), MEMBER(phn_info, output_nodes),
    MEMBER(phn_info, fixed_nodes), MEMBER(phn_info, output_points), MEMBER(phn_info, fixed_points),
    MEMBER(phn_info, triangles), MEMBER(phn_info, field_names), MEMBER(phn_info, field_units),
    MEMBER(phn_info, n_nodes), MEMBER(phn_info, n_active), MEMBER(phn_info, n_output), MEMBER(phn_info, n_fixed),
    MEMBER(phn_info, n_triangles), MEMBER(phn_info, n_fields), MEMBER(phn_info, n_levels),
    MEMBER(phn_info, has_energy), MEMBER(phn_info, provenance),
    MEMBER(phn_provenance, physics_hash), MEMBER(phn_provenance, element), MEMBER(phn_provenance, reference),
    MEMBER(phn_provenance, shear_modulus_Pa), MEMBER(phn_provenance, finer_mean), MEMBER(phn_provenance, finer_p95),
    MEMBER(phn_provenance, finer_tool_radius_m), MEMBER(phn_provenance, finer_probes),
    MEMBER(phn_provenance, finer_nodes), MEMBER(phn_provenance, bound_reference),
    SIZE(phn_tool), MEMBER(phn_tool, nodes), MEMBER(phn_tool, weights), MEMBER(phn_tool, displacement),
    SIZE(phn_coupled), MEMBER(phn_coupled, residual), MEMBER(phn_coupled, energy),
    SIZE(phn_level), MEMBER(phn_level, force_centers), MEMBER(phn_level, deformation_centers),
    MEMBER(phn_level, modes), MEMBER(phn_level, error_force), MEMBER(phn_level, error_displacement),
    SIZE(phn_contact_tool), MEMBER(phn_contact_tool, center), MEMBER(phn_contact_tool, radius),
    MEMBER(phn_contact_tool, friction), MEMBER(phn_contact_tool, mode),
    SIZE(phn_contact_state), MEMBER(phn_contact_state, force), MEMBER(phn_contact_state, proxy),
    MEMBER(phn_contact_state, normal), MEMBER(phn_contact_state, scale), MEMBER(phn_contact_state, unbalanced),
    MEMBER(phn_contact_state, held), MEMBER(phn_contact_state, in_contact),
    SIZE(phn_body_info), MEMBER(phn_body_info, mesh_hash), MEMBER(phn_body_info, physics_hash),
    MEMBER(phn_body_info, law), MEMBER(phn_body_info, tool_radius_m), MEMBER(phn_body_info, max_displacement_m),
    MEMBER(phn_body_info, nodes), MEMBER(phn_body_info, n_nodes), MEMBER(phn_body_info, n_modes),
    MEMBER(phn_body_info, n_cells),
    SIZE(phn_body_pressed), MEMBER(phn_body_pressed, energy), MEMBER(phn_body_pressed, behind_m),
    {0, 0}};
/* clang-format on */

/* Entries of a name (address) and a number of bytes; the last name is 0. */
const entry* phn_layout(void);
const entry* phn_layout(void) { return entries; }
