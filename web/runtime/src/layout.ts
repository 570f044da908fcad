// The structs of the C interface in the 32-bit memory of the module, with their members in the order of the headers.

type Kind = readonly [bytes: number, alignment: number, read?: 'integer' | 'real' | 'text'];
const integer: Kind = [4, 4, 'integer'], text: Kind = [4, 4, 'text'], pointer: Kind = [4, 4], double: Kind = [8, 8, 'real'];
const several = (n: number, [bytes, alignment]: Kind): Kind => [n * bytes, alignment];

/** Numbers and texts of the structs: their names in camel case without units, kinds and offsets. */
export const readable: Record<string, { key: string; read: 'integer' | 'real' | 'text'; offset: number }[]> = {};

/** Bytes of a struct by its name, and the offset of a member by STRUCT.MEMBER. */
function struct<Name extends string, Member extends string>(name: Name, members: Record<Member, Kind>):
  Readonly<Record<Name | `${Name}.${Member}`, number>> {
  const table: Record<string, number> = {}, roundedUp = (n: number, unit: number) => Math.ceil(n / unit) * unit;
  let end = 0, largest = 1;
  const found = (readable[name] = [] as (typeof readable)[string]);
  for (const [member, [bytes, alignment, read]] of Object.entries<Kind>(members)) {
    const at = roundedUp(end, alignment), key = member.replace(/_(Pa|m)$/, '').replace(/_(\w)/g, (_, letter: string) => letter.toUpperCase());
    table[`${name}.${member}`] = at;
    if (read && member !== 'reserved') found.push({ key, read, offset: at });
    end = at + bytes;
    largest = Math.max(largest, alignment);
  }
  return { ...table, [name]: roundedUp(end, largest) } as Record<Name | `${Name}.${Member}`, number>;
}

const texts = several(8, pointer), vector = several(3, double);
const provenance = struct('phn_provenance', {
  mesh_hash: text, physics_hash: text, element: text, reference: text, shear_modulus_Pa: double,
  finer_mean: double, finer_p95: double, finer_tool_radius_m: double, finer_probes: integer, finer_nodes: integer,
  bound_reference: integer, reserved: integer,
});
const relaxation = struct('phn_relaxation', {
  g: several(8, double), tau_s: several(8, double), length_m: double, n_terms: integer, reserved: integer,
});
const tool = struct('phn_tool', { nodes: several(3, integer), weights: vector, displacement: vector, reserved: several(2, integer) });

export const layout = {
  ...provenance,
  ...tool,
  ...struct('phn_info', {
    family: text, title: text, mesh_hash: text, max_displacement_m: double, active_nodes: pointer,
    output_nodes: pointer, fixed_nodes: pointer, output_points: pointer, fixed_points: pointer, triangles: pointer,
    field_names: texts, field_units: texts, n_nodes: integer, n_active: integer, n_output: integer, n_fixed: integer,
    n_triangles: integer, n_fields: integer, n_levels: integer, has_energy: integer, provenance: [provenance.phn_provenance, 8],
    relaxation: [relaxation.phn_relaxation, 8],
    reserved: several(4, integer),
  }),
  ...struct('phn_coupled', { residual: double, energy: double, reserved: several(2, integer) }),
  ...struct('phn_level', {
    force_centers: integer, deformation_centers: integer, modes: integer, error_force: double, error_displacement: double,
    reserved: several(2, integer),
  }),
  ...struct('phn_surface_contents', {
    n_vertices: integer, n_triangles: integer, triangles: pointer, points: pointer, scratch_bytes: integer,
    reserved: several(2, integer),
  }),
  ...struct('phn_contact_tool', { center: vector, radius: double, friction: double, mode: integer, reserved: integer }),
  ...struct('phn_contact_state', {
    force: vector, proxy: vector, normal: vector, scale: double, unbalanced: double, held: [tool.phn_tool, 8], in_contact: integer, reserved: integer,
  }),
  ...struct('phn_contact_report', { energy: double, residual_m: double, unbalanced: double, steps: integer, reserved: integer }),
  ...struct('phn_body_contents', {
    mesh_hash: text, physics_hash: text, law: text, relaxation: [relaxation.phn_relaxation, 8], tool_radius_m: double, max_displacement_m: double, nodes: pointer,
    points: pointer, triangles: pointer, n_nodes: integer, n_triangles: integer, n_modes: integer, n_pressures: integer,
    n_cells: integer, reserved: integer,
  }),
  ...struct('phn_body_report', { energy: double, unbalanced: double, residual_m: double, steps: integer, renewed: integer, reserved: several(2, integer) }),
};
