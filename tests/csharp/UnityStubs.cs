// What examples/unity/OrganView.cs uses of Unity, and a program that runs it with them. What only Unity shows, it does not
// show. Claims: OrganView draws the organ at rest without a device, moves what a device presses and the sphere with it, and
// says what a device threw. Usage: Unity.exe MODEL, a block of round tools.
using System;
using System.Reflection;
using System.Threading;
using Phynness;

namespace UnityEngine {

public struct Touch {}
public struct Vector3 {
  public float x, y, z;
  public Vector3(float x, float y, float z) {
    this.x = x;
    this.y = y;
    this.z = z;
  }
  public static Vector3 one { get { return new Vector3(1, 1, 1); } }
  public static Vector3 operator *(Vector3 a, float b) { return new Vector3(b * a.x, b * a.y, b * a.z); }
}
public class Transform { public Vector3 localPosition, localScale; }
public class MeshFilter { public Mesh mesh; }
public class MeshRenderer {}
public class Mesh {
  public Rendering.IndexFormat indexFormat;
  public Vector3[] vertices;
  public int[] triangles;
  public void MarkDynamic() {}
  public void RecalculateNormals() {}
  public void RecalculateBounds() {}
}
public class MonoBehaviour {
  public bool enabled = true;
  public static readonly System.Collections.Generic.List<object> Components = new System.Collections.Generic.List<object>();
  public T GetComponent<T>() {
    foreach (object component in Components)
      if (component is T found) return found;
    return default(T);
  }
}
public static class Application { public static string streamingAssetsPath = "."; }
public static class Debug {
  public static string Error;
  public static void LogError(string message) { Error = message; }
}
public sealed class RequireComponent : Attribute {
  public RequireComponent(Type one, Type other) {}
}

namespace Rendering {
public enum IndexFormat { UInt16, UInt32 }
}

}  // namespace UnityEngine

static class Program {
  /// Descends from a place by 20 um a cycle.
  sealed class Device : IHapticDevice {
    public Vec3 At;
    public bool IsLost;
    public bool Read(out Vec3 position) {
      if (IsLost) throw new InvalidOperationException("no device");
      At.Z -= 2e-5;
      position = At;
      return true;
    }
    public void Apply(Vec3 force) {}
  }
  static int failures;
  static void Require(bool holds, string claim) {
    if (holds) return;
    Console.Error.WriteLine("FAILED: " + claim);
    ++failures;
  }
  const BindingFlags own = BindingFlags.NonPublic | BindingFlags.Instance;
  static void Call(OrganView view, string method) { typeof(OrganView).GetMethod(method, own).Invoke(view, null); }

  static int Main(string[] words) {
    var filter = new UnityEngine.MeshFilter();
    UnityEngine.MonoBehaviour.Components.Add(filter);
    var view = new OrganView { modelFolder = words[0], sphere = new UnityEngine.Transform() };
    Call(view, "Start");
    var rest = (UnityEngine.Vector3[])filter.mesh.vertices.Clone();
    Call(view, "Update");
    Func<float> moved = () => {
      float most = 0;
      for (int i = 0; i < rest.Length; ++i) most = Math.Max(most, filter.mesh.vertices[i].z - rest[i].z);
      return most;
    };
    Require(rest.Length > 40 && moved() == 0, "without a device the organ is drawn at rest");

    // In the time of the loop, without a thread: the sphere of 5 mm begins 1 mm above the middle of the top face, at
    // z = 0.03 m, and goes 3 mm into it.
    var device = new Device { At = new Vec3(0.06, 0.06, 0.036) };
    var haptics = new HapticThread(Organ.Load(words[0]), device, view.radius, view.friction, LoopSettings.Defaults);
    typeof(OrganView).GetField("haptics", own).SetValue(view, haptics);
    for (int i = 1; i <= 200; ++i) haptics.Cycle(1e-3 * i);
    Call(view, "Update");
    Require(moved() > 0.001f && moved() < 0.003f, "a device presses the top down: " + moved() + " m");
    float height = -view.sphere.localPosition.z;
    Require(height > 0.032f && height < 0.034f && view.sphere.localScale.x == 0.01f, "the sphere is in it: " + height + " m");
    Call(view, "OnDestroy");

    device.IsLost = true;
    UnityEngine.MonoBehaviour.Components.Add(device);
    Call(view, "Start");
    for (int i = 0; i < 1000 && view.enabled; ++i) {
      Call(view, "Update");
      Thread.Sleep(10);
    }
    Call(view, "OnDestroy");
    Require(!view.enabled && UnityEngine.Debug.Error.Contains("no device"), "what a device threw is said");
    return failures;
  }
}
