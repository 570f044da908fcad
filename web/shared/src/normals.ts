// Normals of a surface.

/** Unit normals of the vertices, weighted by the areas of the triangles; zeros where there is none. */
export function normalsOf(positions: ArrayLike<number>, triangles: ArrayLike<number>, out: Float32Array): Float32Array {
  out.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t]!, b = 3 * triangles[t + 1]!, c = 3 * triangles[t + 2]!;
    const ux = positions[b]! - positions[a]!, uy = positions[b + 1]! - positions[a + 1]!, uz = positions[b + 2]! - positions[a + 2]!;
    const vx = positions[c]! - positions[a]!, vy = positions[c + 1]! - positions[a + 1]!, vz = positions[c + 2]! - positions[a + 2]!;
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    out[a] = out[a]! + x; out[a + 1] = out[a + 1]! + y; out[a + 2] = out[a + 2]! + z;
    out[b] = out[b]! + x; out[b + 1] = out[b + 1]! + y; out[b + 2] = out[b + 2]! + z;
    out[c] = out[c]! + x; out[c + 1] = out[c + 1]! + y; out[c + 2] = out[c + 2]! + z;
  }
  for (let i = 0; i < out.length; i += 3) {
    const size = Math.hypot(out[i]!, out[i + 1]!, out[i + 2]!);
    if (size > 0) for (let k = 0; k < 3; ++k) out[i + k] = out[i + k]! / size;
  }
  return out;
}
