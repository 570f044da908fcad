// Prints the answers of bindings/csharp bit by bit, as answers.cpp prints those of phynness::Organ, and with --claims checks
// what only C# has: no garbage in 10^6 calls, threads, and an exception with a sentence for each wrong use.
// Usage: Answers.exe MODEL|- BODY|- [--claims]
using System;
using System.IO;
using System.Text;
using System.Threading;
using Phynness;

static class Answers {
  static readonly StringBuilder text = new StringBuilder();

  static void Print(string what, int status, params double[] numbers) {
    text.Append(what).Append(' ').Append(status);
    foreach (double x in numbers) text.Append(' ').Append(BitConverter.DoubleToInt64Bits(x).ToString("x16"));
    text.Append('\n');
  }
  static double Mixed(Vec3[] field) {
    ulong all = 0;
    foreach (Vec3 u in field)
      foreach (double x in new[] { u.X, u.Y, u.Z }) all = (all << 1 | all >> 63) ^ (ulong)BitConverter.DoubleToInt64Bits(x);
    return BitConverter.Int64BitsToDouble((long)all);
  }
  static uint state = 1;
  static double Random() {
    state = unchecked(state * 1664525u + 1013904223u);
    return (state >> 8) / 16777216.0;
  }
  /// The status of a call that may be refused.
  static int Of(Func<Status> call) {
    try {
      return (int)call();
    } catch (PhynnessException error) {
      return (int)error.Status;
    }
  }

  static int Main(string[] words) {
    string model = words[0] == "-" ? null : words[0], body = words[1] == "-" ? null : words[1];
    if (words.Length > 2) return Claims(model, body);
    using (Organ organ = Organ.Load(model, body, 2)) PrintAnswers(organ, body != null);
    Console.Write(text);
    return 0;
  }

  static void PrintAnswers(Organ organ, bool hasBody) {
    Vec3[] points = organ.MovingPoints, field = new Vec3[organ.MovingCount], forces = new Vec3[2];
    double depth = organ.MaxDisplacement;
    text.Append(points.Length).Append(" nodes\n");
    Vec3 top = new Vec3(0, 0, -1e300);
    foreach (Vec3 x in points)
      if (x.Z > top.Z) top = x;
    var tools = new Tool[2];
    var report = new Report();
    var history = new Relaxing();
    for (int call = 0; call < 100; ++call) {
      Vec3 point = new Vec3(), force = new Vec3();
      double distance = 0, energy = 0;
      for (int t = 0; t < 2; ++t) {
        Vec3 at = points[call % points.Length];
        at.X += 0.3 * depth * Random();
        at.Y += 0.3 * depth * Random();
        at.Z += 0.3 * depth * Random();
        Print("nearest", Of(() => organ.Nearest(at, out tools[t], out point, out distance)), distance);
        tools[t].Displacement.X = depth * (Random() - 0.5);
        tools[t].Displacement.Y = depth * (Random() - 0.5);
        tools[t].Displacement.Z = depth * (Random() - 0.5);
      }
      Print("point", 0, point.X, point.Y, point.Z);
      Print("hold", Of(() => organ.Hold(ref tools[0], out force, out energy)), force.X, force.Y, force.Z);
      Print("energy", 0, energy);
      if (call == 50) history.Outward = new Vec3(0, 0, 1);
      Print("relax", Of(() => organ.Relax(ref history, point, 0.01, ref force)), force.X, force.Y, force.Z);
      Print("deform", Of(() => organ.Deform(field)));
      Print("field", 0, Mixed(field));
      var bounds = new double[1];
      int bounded = Of(() => organ.Bound(bounds));
      Print("bound", bounded, double.IsInfinity(bounds[0]) ? 1e300 : bounds[0]);
      int two = Of(() => organ.Hold(tools, 2, forces, out report));
      Print("two", two, forces[0].X, forces[0].Y, forces[0].Z, forces[1].X, forces[1].Y, forces[1].Z);
      Print("energy", 0, report.Energy);
    }
    int n = hasBody ? 2 : 1;
    var spheres = new Sphere[2];
    for (int call = 0; call < 300; ++call) {
      var touches = new Touch[2];
      for (int s = 0; s < 2; ++s)
        spheres[s] = new Sphere { Center = new Vec3(top.X + (s - 0.5) * depth, top.Y, top.Z + 2 * depth - 0.01 * depth * call),
                                  Radius = 0.3 * depth, Friction = 0.3, Mode = (SphereMode)(s + 1) };
      int status = Of(() => organ.Touch(spheres, n, touches, out report));
      for (int s = 0; s < 2; ++s) {
        Vec3 f = touches[s].Force, p = touches[s].Proxy, m = touches[s].Normal;
        Print(s == 0 ? "touch" : "second", s == 0 ? status : touches[0].InContact ? 1 : 0, f.X, f.Y, f.Z, p.X, p.Y, p.Z, m.X, m.Y, m.Z);
      }
      Print("energy", 0, report.Energy);
    }
    Print("deform", Of(() => organ.Deform(field)));
    Print("field", 0, Mixed(field));
    Print("reset", Of(organ.Reset));
  }

  // ---- claims -----------------------------------------------------------------------------------------------------------

  static int failures;
  static void Require(bool holds, string claim) {
    if (holds) return;
    Console.Error.WriteLine("FAILED: " + claim);
    ++failures;
  }
  static void RequireThrows<E>(Action call, string claim, params string[] parts) where E : Exception {
    try {
      call();
      Require(false, claim + ": nothing was thrown");
    } catch (E error) {
      foreach (string part in parts) Require(error.Message.Contains(part), claim + ": \"" + error.Message + "\" does not say " + part);
    }
  }

  static int Claims(string model, string body) {
    Organ organ = Organ.Load(model, body, 2);
    int node = organ.ActiveNodes[0];
    Tool tool = Tool.At(node, new Vec3(0, 0, 0.3 * organ.MaxDisplacement));
    Vec3 force;
    organ.Hold(ref tool, out force);

    // Ten thousand calls of each verb first, for what is made at the first one.
    var field = new Vec3[organ.MovingCount];
    var spheres = new[] { new Sphere { Center = organ.MovingPoints[0], Radius = 0.01, Mode = SphereMode.Press } };
    var touches = new Touch[1];
    var bounds = new double[1];
    Report report;
    Vec3 point;
    Tool place;
    double distance;
    Tool[] several = { tool, Tool.At(-1, new Vec3()) };
    Tool[] nearest = new Tool[2];
    var answers = new Vec3[2];
    var history = new Relaxing();
    var statuses = new Status[2];
    var distances = new double[2];
    Action<int> calls = count => {
      for (int i = 0; i < count; ++i) {
        organ.HoldBatch(several, 0, 2, answers, statuses);
        organ.Hold(ref tool, out force);
        organ.Relax(ref history, first, 0.001, ref force);
        if (i % 100 != 0) continue;
        organ.Nearest(first, out place, out point, out distance);
        organ.Deform(field);
        organ.Bound(bounds);
        organ.Touch(spheres, 1, touches, out report);
      }
    };
    first = organ.MovingPoints[0];
    calls(10000);
    GC.Collect();
    int collections = GC.CollectionCount(0);
    long before = GC.GetTotalMemory(true);
    collections = GC.CollectionCount(0);
    calls(1000000);
    Require(GC.CollectionCount(0) == collections, "a million calls collect no garbage");
    Require(GC.GetTotalMemory(false) - before < 65536, "a million calls leave no garbage");

    Require(answers[0].Equals(force) && answers[1].Equals(new Vec3()), "a batch has the forces of single calls");
    Require(statuses[0] >= 0 && statuses[1] == Status.ErrorNotActive, "a batch has the status of each tool");
    organ.NearestBatch(organ.MovingPoints, 0, 2, nearest, answers, distances, statuses);
    organ.Nearest(organ.MovingPoints[1], out place, out point, out distance);
    Require(answers[1].Equals(point) && distances[1] == distance, "a batch finds the places of single calls");
    answers[0] = new Vec3();
    organ.HoldBatch(several, 1, 2, answers, statuses);
    Require(answers[0].Equals(new Vec3()), "a batch leaves what is before its begin");
    RequireThrows<ArgumentException>(() => organ.HoldBatch(several, 0, 3, answers, statuses), "a short batch", "3");
    RequireThrows<ArgumentException>(() => organ.HoldBatch(several, -1, 2, answers, statuses), "a batch from -1", "-1");

    RequireThrows<PhynnessException>(() => organ.Relax(ref history, first, 0, ref answers[0]), "a step of no time", "time");

    // Threads with an organ of their own have the same bits; two in one organ are told so.
    Vec3 expected = force;
    int different = 0;
    var threads = new Thread[4];
    for (int t = 0; t < threads.Length; ++t) {
      threads[t] = new Thread(() => {
        using (Organ own = organ.Another()) {
          Tool same = tool;
          for (int i = 0; i < 10000; ++i) {
            Vec3 f;
            own.Hold(ref same, out f);
            if (f.X != expected.X || f.Y != expected.Y || f.Z != expected.Z) Interlocked.Increment(ref different);
          }
        }
      });
      threads[t].Start();
    }
    foreach (Thread thread in threads) thread.Join();
    Require(different == 0, "threads have the same forces");
    int told = 0;
    DateTime begin = DateTime.UtcNow;
    ThreadStart both = () => {
      Tool same = tool;
      while (told == 0 && (DateTime.UtcNow - begin).TotalSeconds < 60) try {
          Vec3 f;
          for (int i = 0; i < 1000; ++i) organ.Hold(ref same, out f);
        } catch (InvalidOperationException error) {
          Require(error.Message.Contains("Another()"), "the remedy for two threads is said");
          Interlocked.Increment(ref told);
        }
    };
    var one = new Thread(both);
    one.Start();
    both();
    one.Join();
    Require(told > 0, "a second thread in one organ is told so");

    Tool nan = Tool.At(node, new Vec3(double.NaN, 0, 0));
    RequireThrows<PhynnessException>(() => organ.Hold(ref nan, out force), "NaN", "NaN");
    Require(force.X == 0 && force.Y == 0 && force.Z == 0, "a refused force is 0");
    RequireThrows<ArgumentException>(() => organ.Deform(new Vec3[1]), "a short array", "1");
    RequireThrows<IOException>(() => Organ.Load("no/such/model"), "a missing folder", "no/such/model");
    RequireThrows<ArgumentException>(() => Organ.Load(model, null, 0), "an organ for no tool", "mostTools", "at least 1");
    string damaged = Path.GetTempFileName();
    File.WriteAllText(damaged, File.ReadAllText(Path.Combine(model, "model.txt")).Substring(0, 2000));
    RequireThrows<PhynnessException>(() => Organ.Load(damaged), "a damaged model", damaged, "byte");
    File.Delete(damaged);

    CheckHaptics(organ);

    organ.Dispose();
    organ.Dispose();
    RequireThrows<ObjectDisposedException>(() => organ.Hold(ref tool, out force), "a released organ");
    return failures;
  }
  static Vec3 first;

  // ---- examples/unity -----------------------------------------------------------------------------------------------------

  /// A device that is pushed down at 20 mm/s from above a place.
  sealed class PushedDevice : IHapticDevice {
    public Vec3 At, Applied;
    public double Largest;
    public bool Read(out Vec3 position) {
      At.Z -= 2e-5;
      position = At;
      return true;
    }
    public void Apply(Vec3 force) {
      Applied = force;
      Largest = Math.Max(Largest, force.Z);
    }
  }
  sealed class LostDevice : IHapticDevice {
    public bool ReadsNone;
    public bool Read(out Vec3 position) {
      position = new Vec3(0, 0, 1);
      return ReadsNone ? throw new IOException("no device") : true;
    }
    public void Apply(Vec3 force) { throw new IOException("no force"); }
  }
  static void CheckHaptics(Organ organ) {
    Vec3[] points = organ.MovingPoints, still = organ.FixedPoints;
    int[] triangles = organ.Triangles;
    var all = new Vec3[points.Length + still.Length];
    points.CopyTo(all, 0);
    still.CopyTo(all, points.Length);
    double volume = Volume(all, triangles);
    Require(volume > 0, "triangles have their normals outward");
    int[] swapped = LeftHanded.Of(triangles);
    for (int i = 0; i < all.Length; ++i) all[i] = LeftHanded.Of(all[i]);
    Require(Math.Abs(Volume(all, swapped) / volume - 1) < 1e-12, "so they have in a left-handed frame, where z and winding are mirrored");

    // The highest triangle whose corners can be touched.
    int[] nodes = organ.MovingNodes, active = organ.ActiveNodes;
    Tool place = Tool.At(active[0], new Vec3());
    Vec3 point = new Vec3(0, 0, -1);
    for (int i = 0; i < triangles.Length; i += 3) {
      int a = triangles[i], b = triangles[i + 1], c = triangles[i + 2];
      bool isActive = true;
      foreach (int corner in new[] { a, b, c })
        isActive = isActive && corner < nodes.Length && Array.BinarySearch(active, nodes[corner]) >= 0;
      double z = isActive ? (points[a].Z + points[b].Z + points[c].Z) / 3 : -1;
      if (z > point.Z) point = new Vec3((points[a].X + points[b].X + points[c].X) / 3, (points[a].Y + points[b].Y + points[c].Y) / 3, z);
    }
    var device = new PushedDevice { At = new Vec3(point.X, point.Y, point.Z + 0.01) };
    LoopSettings settings = LoopSettings.Defaults;
    using (var haptics = new HapticThread(organ.Another(), device, 0.005, 0.3, settings)) {
      Touch touch;
      for (int i = 1; i <= 600; ++i) haptics.Cycle(1e-3 * i);  // 12 mm
      LoopReport report = haptics.Latest(out touch);
      Require(report.State == LoopState.On && touch.InContact, "a device that is pushed in stays in contact: " + report.TripMessage);
      Require(device.Largest > 0.005 && device.Applied.Z > 0, "and feels a force against its motion");
      device.At.X = double.NaN;
      haptics.Cycle(0.601);
      report = haptics.Latest(out touch);
      Require(report.State == LoopState.Tripped && report.TripMessage.Length > 10, "NaN of a device trips the loop");
      Require(device.Applied.X == 0 && device.Applied.Y == 0 && device.Applied.Z == 0, "whose force is then 0");
      Require(organ.Hold(ref place, out point) >= 0, "and the organ goes on");
    }
    settings.TripStale = settings.TripOverrun = 0;  // a busy machine
    using (var haptics = new HapticThread(organ.Another(), device, 0.005, 0.3, settings)) {
      device.At = new Vec3(point.X, point.Y, 1);
      haptics.Start();
      RequireThrows<InvalidOperationException>(haptics.Start, "a thread that is started twice", "before");
      Thread.Sleep(50);
      Require(haptics.Fault == null, "a device that answers stops no thread");
    }
    Require(device.Applied.Z == 0, "the last force of a thread that ends is 0");
    RequireThrows<ArgumentNullException>(() => new HapticThread(organ, null, 0.005, 0.3, settings), "no device", "device");
    foreach (bool isFirst in new[] { true, false })  // what Apply throws is thrown again by the last force
      using (var haptics = new HapticThread(organ.Another(), new LostDevice { ReadsNone = isFirst }, 0.005, 0.3, settings)) {
        haptics.Start();
        for (int i = 0; i < 1000 && haptics.Fault == null; ++i) Thread.Sleep(10);
        Require(haptics.Fault != null && haptics.Fault.Message == (isFirst ? "no device" : "no force"), "what a device throws is kept");
      }
  }
  static double Volume(Vec3[] x, int[] triangles) {
    double sum = 0;
    for (int i = 0; i < triangles.Length; i += 3) {
      Vec3 a = x[triangles[i]], b = x[triangles[i + 1]], c = x[triangles[i + 2]];
      sum += a.X * (b.Y * c.Z - b.Z * c.Y) + a.Y * (b.Z * c.X - b.X * c.Z) + a.Z * (b.X * c.Y - b.Y * c.X);
    }
    return sum;
  }
}
