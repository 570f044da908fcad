// Draws an organ in Unity and lets a device touch it: docs/howto/csharp.md says what belongs where.
#if UNITY_5_3_OR_NEWER
using System.IO;
using Phynness;
using UnityEngine;
using Touch = Phynness.Touch;

[RequireComponent(typeof(MeshFilter), typeof(MeshRenderer))]
public sealed class OrganView : MonoBehaviour {
  /// Below StreamingAssets.
  public string modelFolder = "model";
  /// Of the sphere [m]; coefficient; largest force of the device [N].
  public double radius = 0.005, friction = 0.3, largestForce = 0.5;
  /// Where the device's origin is in the organ's frame [m].
  public Vector3 origin;
  /// A unit sphere that is a child of this object, or none.
  public Transform sphere;

  Organ felt, seen;
  HapticThread haptics;
  Vec3[] rest, field;
  Vector3[] vertices;
  Mesh mesh;

  void Start() {
    felt = Organ.Load(Path.Combine(Application.streamingAssetsPath, modelFolder));
    seen = felt.Another();
    rest = felt.MovingPoints;
    field = new Vec3[rest.Length];
    Vec3[] still = felt.FixedPoints;
    vertices = new Vector3[rest.Length + still.Length];
    for (int i = 0; i < rest.Length; ++i) vertices[i] = Drawn(rest[i], field[i]);
    for (int i = 0; i < still.Length; ++i) vertices[rest.Length + i] = Drawn(still[i], new Vec3());
    mesh = new Mesh { indexFormat = UnityEngine.Rendering.IndexFormat.UInt32, vertices = vertices,
                      triangles = LeftHanded.Of(felt.Triangles) };
    mesh.MarkDynamic();
    mesh.RecalculateNormals();
    GetComponent<MeshFilter>().mesh = mesh;
    var device = GetComponent<IHapticDevice>();
    if (device == null) return;  // the organ at rest is drawn
    LoopSettings settings = LoopSettings.Defaults;
    settings.Origin = LeftHanded.Of(new Vec3(origin.x, origin.y, origin.z));
    settings.LargestForce = largestForce;
    haptics = new HapticThread(felt, device, radius, friction, settings);
    haptics.Start();
  }
  void Update() {
    if (haptics == null) return;
    LoopReport report = haptics.Latest(out Touch touch);
    if (haptics.Fault != null || report.State == LoopState.Tripped) {
      Debug.LogError("the haptic loop stopped: " + (haptics.Fault?.ToString() ?? report.TripMessage));
      enabled = false;  // no Update follows
    }
    if (sphere != null) {
      sphere.localPosition = Drawn(touch.Proxy, touch.Held.Displacement);
      sphere.localScale = Vector3.one * (float)(2 * radius);
    }
    if (touch.InContact) {
      seen.Hold(ref touch.Held, out _);
      seen.Deform(field);
    } else {
      System.Array.Clear(field, 0, field.Length);
    }
    for (int i = 0; i < rest.Length; ++i) vertices[i] = Drawn(rest[i], field[i]);
    mesh.vertices = vertices;
    mesh.RecalculateNormals();
    mesh.RecalculateBounds();
  }
  void OnDestroy() { haptics?.Dispose(); felt?.Dispose(); seen?.Dispose(); }
  static Vector3 Drawn(Vec3 x, Vec3 u) {
    Vec3 left = LeftHanded.Of(new Vec3(x.X + u.X, x.Y + u.Y, x.Z + u.Z));
    return new Vector3((float)left.X, (float)left.Y, (float)left.Z);
  }
}
#endif
