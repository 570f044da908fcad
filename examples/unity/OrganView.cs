// Draws an organ in Unity and lets a device touch it. Put the files of docs/howto/csharp.md into Assets, add this component to
// a GameObject, and give it a material.
#if UNITY_5_3_OR_NEWER
using System.IO;
using Phynness;
using UnityEngine;
using Touch = Phynness.Touch;

[RequireComponent(typeof(MeshFilter), typeof(MeshRenderer))]
public sealed class OrganView : MonoBehaviour {
  /// Below StreamingAssets; a body is needed for several tools only.
  public string modelFolder = "model", bodyFile = "";
  public double radius = 0.005, friction = 0.3;
  /// A component that has IHapticDevice.
  public MonoBehaviour device;

  Organ felt, seen;
  HapticThread haptics;
  Vec3[] rest, field;
  Vector3[] vertices;
  Mesh mesh;
  bool wasTripped;

  void Start() {
    string folder = Path.Combine(Application.streamingAssetsPath, modelFolder);
    felt = Organ.Load(folder, bodyFile == "" ? null : Path.Combine(Application.streamingAssetsPath, bodyFile));
    seen = felt.Another();
    rest = felt.MovingPoints;
    field = new Vec3[rest.Length];
    Vec3[] still = felt.FixedPoints;
    vertices = new Vector3[rest.Length + still.Length];
    for (int i = 0; i < rest.Length; ++i) vertices[i] = Drawn(rest[i]);
    for (int i = 0; i < still.Length; ++i) vertices[rest.Length + i] = Drawn(still[i]);
    mesh = new Mesh { indexFormat = UnityEngine.Rendering.IndexFormat.UInt32, vertices = vertices,
                      triangles = LeftHanded.Of(felt.Triangles) };
    mesh.MarkDynamic();
    GetComponent<MeshFilter>().mesh = mesh;
    haptics = new HapticThread(felt, (IHapticDevice)device, radius, friction, LoopSettings.Defaults);
    haptics.Start();
  }
  void Update() {
    Touch touch;
    LoopReport report = haptics.Latest(out touch);
    if (report.State == LoopState.Tripped && !wasTripped) Debug.LogError("the haptic loop stopped: " + report.TripMessage);
    wasTripped = report.State == LoopState.Tripped;
    if (touch.InContact) {
      Vec3 force;
      seen.Hold(ref touch.Held, out force);
      seen.Deform(field);
    } else {
      System.Array.Clear(field, 0, field.Length);
    }
    for (int i = 0; i < rest.Length; ++i)
      vertices[i] = Drawn(new Vec3(rest[i].X + field[i].X, rest[i].Y + field[i].Y, rest[i].Z + field[i].Z));
    mesh.vertices = vertices;
    mesh.RecalculateNormals();
    mesh.RecalculateBounds();
  }
  void OnDestroy() {
    if (haptics != null) haptics.Dispose();
    if (felt != null) felt.Dispose();
    if (seen != null) seen.Dispose();
  }
  static Vector3 Drawn(Vec3 x) {
    Vec3 left = LeftHanded.Of(x);
    return new Vector3((float)left.X, (float)left.Y, (float)left.Z);
  }
}
#endif
