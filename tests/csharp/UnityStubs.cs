// What examples/unity/OrganView.cs uses of Unity, so that it is compiled. What only Unity shows, it does not show.
using System;

namespace UnityEngine {

public struct Touch {}
public struct Vector3 {
  public float x, y, z;
  public Vector3(float x, float y, float z) {
    this.x = x;
    this.y = y;
    this.z = z;
  }
}
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
  public T GetComponent<T>() where T : new() { return new T(); }
}
public static class Application { public static string streamingAssetsPath = "."; }
public static class Debug { public static void LogError(string message) {} }
public sealed class RequireComponent : Attribute {
  public RequireComponent(Type one, Type other) {}
}

namespace Rendering {
public enum IndexFormat { UInt16, UInt32 }
}

}  // namespace UnityEngine
