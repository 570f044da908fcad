// Written by web/wasm/layout.mjs. Bytes in 32-bit memory: sizes of structs, and offsets of their members.
export const layout = {
  'phn_info': 208, 'phn_info.family': 0, 'phn_info.title': 4, 'phn_info.mesh_hash': 8,
  'phn_info.max_displacement_m': 16, 'phn_info.active_nodes': 24, 'phn_info.output_nodes': 28, 'phn_info.fixed_nodes': 32,
  'phn_info.output_points': 36, 'phn_info.fixed_points': 40, 'phn_info.triangles': 44, 'phn_info.field_names': 48,
  'phn_info.field_units': 80, 'phn_info.n_nodes': 112, 'phn_info.n_active': 116, 'phn_info.n_output': 120,
  'phn_info.n_fixed': 124, 'phn_info.n_triangles': 128, 'phn_info.n_fields': 132, 'phn_info.n_levels': 136,
  'phn_info.has_energy': 140, 'phn_info.provenance': 144, 'phn_provenance.physics_hash': 4, 'phn_provenance.element': 8,
  'phn_provenance.reference': 12, 'phn_provenance.shear_modulus_Pa': 16, 'phn_provenance.finer_mean': 24, 'phn_provenance.finer_p95': 32,
  'phn_provenance.finer_tool_radius_m': 40, 'phn_provenance.finer_probes': 48, 'phn_provenance.finer_nodes': 52, 'phn_provenance.element_revision': 56,
  'phn_provenance.bound_reference': 60, 'phn_tool': 64, 'phn_tool.nodes': 0, 'phn_tool.weights': 16,
  'phn_tool.displacement': 40, 'phn_coupled': 16, 'phn_coupled.residual': 0, 'phn_coupled.energy': 8,
  'phn_trusted': 64, 'phn_trusted.trained_depth': 0, 'phn_trusted.distance': 8, 'phn_trusted.relative': 16,
  'phn_level': 32, 'phn_level.force_centers': 0, 'phn_level.deformation_centers': 4, 'phn_level.modes': 8,
  'phn_level.error_force': 16, 'phn_level.error_displacement': 24, 'phn_contact_tool': 48, 'phn_contact_tool.center': 0,
  'phn_contact_tool.radius': 24, 'phn_contact_tool.friction': 32, 'phn_contact_tool.mode': 40, 'phn_contact_state': 160,
  'phn_contact_state.force': 0, 'phn_contact_state.proxy': 24, 'phn_contact_state.normal': 48, 'phn_contact_state.scale': 72,
  'phn_contact_state.unbalanced': 80, 'phn_contact_state.held': 88, 'phn_contact_state.in_contact': 152,
} as const;
