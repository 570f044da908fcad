/* phynness: the names of the library whose inner loops compute in float. A source file that uses the names of the other
 * headers is compiled for this library if PHYNNESS_FLOAT is defined (the CMake target phynness::runtime_float defines
 * it) or if this header is included before them. The symbols of the two libraries differ (phnf_force and phn_force), so
 * that a file compiled for one cannot be linked with the other by mistake. A program may use both libraries in
 * different files.
 *
 * In float, forces of the families rbfn and modal, stiffnesses of the family modal and deformations of the family rbfn
 * have rounding errors of 1e-7 of their largest terms. Energies are summed in double. A model.txt with weights beyond
 * 1e25, or with networks whose output could reach 1e37 m, is refused (PHN_ERROR_RANGE).
 */
#ifndef PHYNNESS_FLOAT_H
#define PHYNNESS_FLOAT_H

#if defined(PHYNNESS_API_H) && !defined(PHYNNESS_FLOAT)
#error "phynness: include phynness_float.h before the other headers of phynness, or define PHYNNESS_FLOAT"
#endif
#ifndef PHYNNESS_FLOAT
#define PHYNNESS_FLOAT
#endif

#define phn_blend_paper phnf_blend_paper
#define phn_bound phnf_bound
#define phn_bound_at phnf_bound_at
#define phn_budget phnf_budget
#define phn_calibrate phnf_calibrate
#define phn_contact phnf_contact
#define phn_contact_held phnf_contact_held
#define phn_contact_init phnf_contact_init
#define phn_contact_nearest phnf_contact_nearest
#define phn_contact_refit phnf_contact_refit
#define phn_contact_reset phnf_contact_reset
#define phn_contact_size phnf_contact_size
#define phn_contact_step phnf_contact_step
#define phn_couple phnf_couple
#define phn_coupled_bound phnf_coupled_bound
#define phn_coupled_deform phnf_coupled_deform
#define phn_data phnf_data
#define phn_data_init phnf_data_init
#define phn_data_size phnf_data_size
#define phn_deform phnf_deform
#define phn_field phnf_field
#define phn_force phnf_force
#define phn_force_at phnf_force_at
#define phn_level_info phnf_level_info
#define phn_level_of phnf_level_of
#define phn_model phnf_model
#define phn_model_info phnf_model_info
#define phn_model_init phnf_model_init
#define phn_model_size phnf_model_size
#define phn_nearest phnf_nearest
#define phn_prepare phnf_prepare
#define phn_set_level phnf_set_level
#define phn_status_message phnf_status_message
#define phn_surface phnf_surface
#define phn_surface_deform phnf_surface_deform
#define phn_surface_init phnf_surface_init
#define phn_surface_n_triangles phnf_surface_n_triangles
#define phn_surface_n_vertices phnf_surface_n_vertices
#define phn_surface_points phnf_surface_points
#define phn_surface_scratch_size phnf_surface_scratch_size
#define phn_surface_size phnf_surface_size
#define phn_surface_triangles phnf_surface_triangles
#define phn_tools_init phnf_tools_init
#define phn_tools_size phnf_tools_size
#define phn_trust phnf_trust
#define phn_trust_at phnf_trust_at
#define phn_version phnf_version

#include <phynness/phynness.h>

#endif
