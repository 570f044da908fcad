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
  /// Descends at 20 mm/s to a depth, where it moves by less than 1 um, as a hand does.
  sealed class Device : IHapticDevice {
    public Vec3 At;
    public double Depth;
    public bool IsLost;
    public int Count;
    public bool Read(out Vec3 position) {
      if (IsLost) throw new InvalidOperationException("no device");
      position = new Vec3(At.X, At.Y, At.Z - Math.Min(2e-5 * ++Count, Depth) + 1e-7 * (Count % 10));
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
  static void Call(OrganView view, string method) {
    typeof(OrganView).GetMethod(method, BindingFlags.NonPublic | BindingFlags.Instance).Invoke(view, null);
  }
  /// Draws for 10 s, or until the loop stops or a vertex is moved by a distance [m] from rest along Unity's z.
  static float Draw(string model, UnityEngine.Transform sphere, float distance) {
    UnityEngine.Debug.Error = null;
    var view = new OrganView { modelFolder = model, sphere = sphere };
    Call(view, "Start");
    UnityEngine.Mesh mesh = view.GetComponent<UnityEngine.MeshFilter>().mesh;
    var rest = (UnityEngine.Vector3[])mesh.vertices.Clone();
    float moved = 0;
    for (int frame = 0; frame < 1000 && (frame == 0 || moved < distance) && view.enabled; ++frame) {
      Call(view, "Update");
      for (int i = 0; i < rest.Length; ++i) moved = Math.Max(moved, mesh.vertices[i].z - rest[i].z);
      Thread.Sleep(10);
    }
    Call(view, "OnDestroy");
    return moved;
  }
  static int Main(string[] words) {
    UnityEngine.MonoBehaviour.Components.Add(new UnityEngine.MeshFilter());
    var sphere = new UnityEngine.Transform();
    Require(Draw(words[0], sphere, 0) == 0 && UnityEngine.Debug.Error == null, "without a device nothing moves");

    // The sphere of 5 mm begins 1 mm above the middle of the top face and goes 3 mm into it.
    var device = new Device { At = new Vec3(0.06, 0.06, 0.036), Depth = 0.004 };
    UnityEngine.MonoBehaviour.Components.Add(device);
    float moved = 0;
    for (int attempt = 0; attempt < 20 && moved < 0.001f; ++attempt) {  // a cycle on a busy machine may be late, which trips
      device.Count = 0;
      moved = Draw(words[0], sphere, 0.001f);
    }
    Require(moved >= 0.001f && moved < 0.003f, "a device presses the top: " + moved + " m, " + UnityEngine.Debug.Error);
    float height = -sphere.localPosition.z;
    Require(height > 0.032f && height < 0.035f && sphere.localScale.x == 0.01f, "the sphere is in it: " + height + " m");
    device.IsLost = true;
    Draw(words[0], sphere, 1);
    Require(UnityEngine.Debug.Error != null && UnityEngine.Debug.Error.Contains("no device"), "what a device threw is said");
    return failures;
  }
}
