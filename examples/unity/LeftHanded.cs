// Between the right-handed frame of a mesh and a left-handed one, as that of Unity: z has the other sign, for positions,
// displacements and forces, both ways, and triangles have the other winding. Energies and depths stay the same.
using Phynness;

public static class LeftHanded {
  public static Vec3 Of(Vec3 x) { return new Vec3(x.X, x.Y, -x.Z); }
  public static int[] Of(int[] triangles) {
    var swapped = (int[])triangles.Clone();
    for (int i = 0; i + 2 < swapped.Length; i += 3) {
      swapped[i + 1] = triangles[i + 2];
      swapped[i + 2] = triangles[i + 1];
    }
    return swapped;
  }
}
