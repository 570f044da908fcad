// phynness for C# 7 and later, Mono, .NET and Unity: one file without packages or unsafe code, for the shared libraries
// phynness and, for Loop, phynness_loop. Meaning, cost, units and errors are described in phynness.h,
// phynness_body.h and phynness_contact.h. All memory of the library is unmanaged, and no verb allocates.
using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;

namespace Phynness {

/// Success, a sum of warnings, or an error.
[Flags]
public enum Status {
  Ok = 0,
  Outside = 1,
  Incomplete = 2,
  Unsettled = 4,
  Near = 8,
  Relaxation = 16,
  ErrorArgument = -1,
  ErrorNotActive = -2,
  ErrorNotFinite = -3,
  ErrorBuffer = -4,
  ErrorTools = -5,
  ErrorRoundTools = -6,
  ErrorUndefined = -7,
  ErrorClock = -8,
  ErrorNotAModel = -9,
  ErrorVersion = -10,
  ErrorTruncated = -11,
  ErrorChecksum = -12,
  ErrorSyntax = -13,
  ErrorRange = -14,
  ErrorFamily = -15,
  ErrorOverlap = -16,
  ErrorTooLarge = -17,
  ErrorGeometry = -18,
  ErrorTooManyTools = -19,
  ErrorImageOfFloats = -20,
  ErrorImageOfDoubles = -21,
  ErrorSetting = -100
}

/// A refused call. Its outputs are zeros.
public sealed class PhynnessException : Exception {
  public PhynnessException(Status status, string message) : base(message) { Status = status; }
  public Status Status { get; }
}

[StructLayout(LayoutKind.Sequential)]
public struct Vec3 {
  public double X, Y, Z;
  public Vec3(double x, double y, double z) => (X, Y, Z) = (x, y, z);
}

/// phn_tool: a place of the surface and its displacement from rest [m].
[StructLayout(LayoutKind.Sequential)]
public struct Tool {
  public int Node0, Node1, Node2;
  public double Weight0, Weight1, Weight2;
  public Vec3 Displacement;
  int reserved0, reserved1;

  public static Tool At(int node, Vec3 displacement) =>
    new Tool { Node0 = node, Node1 = -1, Node2 = -1, Weight0 = 1, Displacement = displacement };
}

/// phn_relaxing: what one tool has of its past. Begin with a new one; Outward is the normal if the tool only pushes.
[StructLayout(LayoutKind.Sequential)]
public struct Relaxing {
  Vec3 r0, r1, r2, r3, r4, r5, r6, r7, elastic, place;
  public Vec3 Outward;
  double moved;
  int steps, reserved;
}

public enum SphereMode { Off = 0, Press = 1, Grasp = 2 }

/// phn_contact_tool.
[StructLayout(LayoutKind.Sequential)]
public struct Sphere {
  public Vec3 Center;
  public double Radius, Friction;
  public SphereMode Mode;
  int reserved;
}

/// phn_contact_state.
[StructLayout(LayoutKind.Sequential)]
public struct Touch {
  public Vec3 Force, Proxy, Normal;
  public double Scale, Unbalanced;
  public Tool Held;
  int inContact, reserved;
  public bool InContact { get { return inContact != 0; } }
}

/// phn_contact_report, of all tools of a call.
[StructLayout(LayoutKind.Sequential)]
public struct Report {
  public double Energy;      // [J]; 0 in family rbfn
  public double Residual;    // the largest distance of a tool from the place that it holds [m]
  public double Unbalanced;  // of a body: the size of the next step over that of the deformation
  public int Steps;
  int reserved;
}

/// A model's folder and, where several tools act, a body's file, with the verbs Nearest, Hold, Touch and Deform. They
/// return Ok or warnings and throw PhynnessException for an error. An object belongs to one thread at a time; Another()
/// makes one of the same model and body for another thread.
public sealed class Organ : IDisposable {
  enum Last { None, OfTool, OfTools, OfSpheres }

  readonly Files files;
  const int StepsToFollow = 20;
  readonly int mostTools, steps;
  readonly Block data, state, contact;
  readonly Vec3[] bodyField;
  readonly Status touchStatus;
  readonly Tool[] one = new Tool[1];
  readonly Vec3[] oneForce = new Vec3[1];
  readonly double[] oneEnergy;  // null in a family that has none
  Tool tool;
  int nTools, isBusy;
  Last last;
  bool isDisposed;

  Organ(Files files, int mostTools, int steps) {
    this.files = files;
    this.mostTools = mostTools;
    this.steps = steps;
    int most = Math.Min(mostTools, Native.MostCoupled);
    if (HasEnergy) oneEnergy = new double[1];
    if (files.Model != null) data = Block.Of(files.Model, mostTools, Native.phn_data_size, Native.phn_data_init);
    if (files.Body != null) state = Block.Of(files.Body, most, Native.phn_body_state_size, Native.phn_body_state_init);
    try {
      contact = files.Body != null
        ? Block.Of(files.Body, most, Native.phn_body_contact_size,
            (IntPtr memory, UIntPtr bytes, IntPtr of, int n, out IntPtr made) =>
              Native.phn_body_contact_init(memory, bytes, of, n, steps, out made))
        : Block.Of(files.Model, most, Native.phn_contact_size, Native.phn_contact_init);
    } catch (PhynnessException error) {
      touchStatus = error.Status;  // An organ without a surface that can be touched is one for Hold alone.
    }
    if (files.Model != null && files.Body != null) bodyField = new Vec3[files.BodyContents.n_nodes];
  }

  /// model: a model's folder or its model.txt; null: a body alone. body: a body.txt; null: a model alone. mostTools: of one
  /// call; a body and contact have at most 8. steps: of Newton's method, at most, that a body makes in a call.
  public static Organ Load(string model, string body = null, int mostTools = 1, int steps = 1) {
    if (model == null && body == null) throw new ArgumentNullException(nameof(model), "give a model or a body");
    if (mostTools < 1) throw new ArgumentOutOfRangeException(nameof(mostTools), mostTools, "at least 1");
    if (steps < 1) throw new ArgumentOutOfRangeException(nameof(steps), steps, "at least 1");
    string file = model != null && Directory.Exists(model) ? Path.Combine(model, "model.txt") : model;
    return new Organ(new Files(file, body), mostTools, steps);
  }
  public Organ Another() { return new Organ(files, mostTools, steps); }

  public string Title { get { return Native.Text(files.Info.title); } }
  public bool HasEnergy { get { return files.Info.has_energy != 0; } }
  /// The largest displacement of the training data [m].
  public double MaxDisplacement { get { return files.Info.max_displacement_m; } }
  /// Copies: numbers of nodes, points at rest [m], and triangles, normals outward in the right-handed frame of the mesh.
  /// Corners of triangles are positions among MovingPoints and then FixedPoints; of a body alone, all points are moving.
  public int[] ActiveNodes { get { return Native.Copy(files.Info.active_nodes, files.Info.n_active); } }
  public int[] MovingNodes { get { return Native.Copy(files.Info.output_nodes, files.Info.n_output); } }
  public Vec3[] MovingPoints { get { return Native.Points(files.Info.output_points, files.Info.n_output); } }
  public Vec3[] FixedPoints { get { return Native.Points(files.Info.fixed_points, files.Info.n_fixed); } }
  public int[] Triangles { get { return Native.Copy(files.Info.triangles, 3 * files.Info.n_triangles); } }
  public int MovingCount { get { return files.Info.n_output; } }

  /// The place of the undeformed surface nearest to x [m] that can be held, its point, and the distance, < 0 inside.
  public Status Nearest(Vec3 x, out Tool place, out Vec3 point, out double distance) {
    Enter();
    int status = files.Model != null
      ? Native.phn_nearest(files.Model.Object, ref x, out place, out point, out distance)
      : Native.phn_body_nearest(files.Body.Object, ref x, out place, out point, out distance);
    return Leave(status);
  }

  /// The force [N] that holds a tool.
  public Status Hold(ref Tool held, out Vec3 force) { return Hold(ref held, out force, out _); }
  /// The same with the stored energy [J], 0 in family rbfn.
  public Status Hold(ref Tool held, out Vec3 force, out double energy) {
    Enter();
    if (files.Model == null) {
      one[0] = held;
      int pressed = Press(1, one, oneForce, out Report report);
      force = oneForce[0];
      energy = report.Energy;
      return Leave(pressed);
    }
    last = Last.OfTool;
    tool = held;
    int status = Native.phn_force(files.Model.Object, data.Object, ref tool, out force, oneEnergy, IntPtr.Zero);
    energy = HasEnergy ? oneEnergy[0] : 0;
    return Leave(status);
  }
  /// Of the first n of several tools. forces: at least n.
  public Status Hold(Tool[] tools, int n, Vec3[] forces, out Report report) {
    report = new Report();
    RequireLengths(n, tools.Length, forces.Length);
    if (n == 1 && files.Model != null) return Hold(ref tools[0], out forces[0], out report.Energy);
    Enter();
    if (files.Body != null) return Leave(Press(n, tools, forces, out report));
    last = Last.OfTools;
    nTools = n;
    int status = Native.phn_couple(files.Model.Object, data.Object, n, tools, forces, out Native.Coupled coupled);
    report.Energy = coupled.energy;
    report.Residual = coupled.residual;
    return Leave(status);
  }
  /// Replaces the force of a Hold by that of the body that relaxes, dt [s] after the Relax before (phn_relax).
  /// place: the point of Nearest.
  public Status Relax(ref Relaxing history, Vec3 place, double dt, ref Vec3 force) {
    Enter();
    return Leave(Native.phn_relax(files.Relaxation.Memory, ref history, ref force, ref place, dt, ref force));
  }
  int Press(int n, Tool[] tools, Vec3[] forces, out Report report) {
    // A body beside a model has not followed the tool that the model answered.
    int most = files.Model == null || last == Last.OfTools ? steps : Math.Max(steps, StepsToFollow);
    last = Last.OfTools;
    nTools = n;
    int status = Native.phn_body_force(files.Body.Object, state.Object, n, tools, most, forces,
                                       out Native.BodyReport made);
    report = new Report { Energy = made.energy, Residual = made.residual_m, Unbalanced = made.unbalanced,
                          Steps = made.steps };
    return status;
  }

  /// Forces [N] of tools begin to end - 1, which do not act on each other, by the model, and the status of each; nothing
  /// is thrown for one of them. Deform and Bound then have no tool. Runs on this thread: other threads, each with its own
  /// Organ, can answer other parts of the same arrays.
  public void HoldBatch(Tool[] tools, int begin, int end, Vec3[] forces, Status[] statuses) {
    EnterBatch(begin, end, Math.Min(tools.Length, statuses.Length), forces.Length);
    for (int i = begin; i < end; ++i)
      statuses[i] = (Status)Native.phn_force(files.Model.Object, data.Object, ref tools[i], out forces[i], null,
                                             IntPtr.Zero);
    last = Last.None;
    Leave(0);
  }
  /// The places nearest to points x [m], their points and distances, and the status of each.
  public void NearestBatch(Vec3[] x, int begin, int end, Tool[] places, Vec3[] points, double[] distances,
                           Status[] statuses) {
    EnterBatch(begin, end, Math.Min(x.Length, statuses.Length),
               Math.Min(places.Length, Math.Min(points.Length, distances.Length)));
    for (int i = begin; i < end; ++i)
      statuses[i] = (Status)Native.phn_nearest(files.Model.Object, ref x[i], out places[i], out points[i],
                                               out distances[i]);
    Leave(0);
  }
  void EnterBatch(int begin, int end, int length, int lengthOfResults) {
    RequireLengths(end, length, lengthOfResults);
    RequireLengths(begin, end, end);
    if (files.Model == null) throw new InvalidOperationException("this Organ has no model, which answers batches");
    Enter();
  }

  /// Moves the first n spheres, in every millisecond of a haptic loop. touches: at least n.
  public Status Touch(Sphere[] spheres, int n, Touch[] touches, out Report report) {
    report = new Report();
    RequireLengths(n, spheres.Length, touches.Length);
    Enter();
    if (contact == null) return Leave((int)touchStatus);
    last = Last.OfSpheres;
    return Leave(Native.phn_contact_step(contact.Object, n, spheres, touches, out report));
  }

  /// Displacements [m] of MovingPoints in the last Hold or Touch, zeros before. field: at least MovingCount. Where a body
  /// answered beside a model, nodes inside of the body stay at 0.
  public Status Deform(Vec3[] field) {
    RequireLengths(MovingCount, field.Length, field.Length);
    Enter();
    bool ofBody = files.Body != null && last >= Last.OfTools;
    Vec3[] made = ofBody && files.Model != null ? bodyField : field;
    int status = 0;
    if (last == Last.None) Array.Clear(field, 0, MovingCount);
    else if (last == Last.OfSpheres) status = Native.phn_contact_deform(contact.Object, made);
    else if (ofBody) status = Native.phn_body_deform(files.Body.Object, state.Object, made);
    else if (last == Last.OfTools) status = Native.phn_coupled_deform(files.Model.Object, data.Object, made);
    else status = Native.phn_deform(files.Model.Object, data.Object, ref tool, made);
    for (int o = 0; made != field && o < files.Rows.Length; ++o)
      field[o] = files.Rows[o] < 0 ? new Vec3() : made[files.Rows[o]];
    return Leave(status);
  }

  /// Bounds [N] of the errors of the forces of the last Hold; +infinity where nothing is known, and after an error.
  public Status Bound(double[] bounds) {
    int n = last == Last.OfTool ? 1 : last == Last.OfTools ? nTools : 0;
    RequireLengths(n, bounds.Length, bounds.Length);
    Enter();
    for (int i = 0; i < bounds.Length; ++i) bounds[i] = double.PositiveInfinity;  // also where the call is refused
    int status = (int)Status.ErrorUndefined;
    if (last == Last.OfTool) status = Native.phn_bound(files.Model.Object, ref tool, bounds);
    else if (n > 0 && files.Body != null) status = Native.phn_body_bound(files.Body.Object, state.Object, n, bounds);
    for (int i = 0; i < n; ++i)
      if (bounds[i] >= Native.NoBound) bounds[i] = double.PositiveInfinity;
    return Leave(status);
  }

  /// The body back to rest, and every contact ended.
  public Status Reset() {
    Enter();
    last = Last.None;
    int status = contact != null ? Native.phn_contact_reset(contact.Object) : 0;
    if (status >= 0 && state != null) status = state.Restart(files.Body, Math.Min(mostTools, Native.MostCoupled),
                                                             Native.phn_body_state_init);
    return Leave(status);
  }

  /// Releases the working memory; that of model and body when the last Organ of them is released.
  public void Dispose() {
    if (isDisposed) return;
    Enter();
    isDisposed = true;
    foreach (Block block in new[] { data, state, contact }) block?.Dispose();
    isBusy = 0;
  }

  void Enter() {
    if (isDisposed) throw new ObjectDisposedException(nameof(Organ));
    if (Interlocked.Exchange(ref isBusy, 1) != 0)
      throw new InvalidOperationException("another thread is inside this Organ; give each thread its own by Another()");
  }
  Status Leave(int status) {
    Volatile.Write(ref isBusy, 0);  // this also keeps the object alive until here
    if (status < 0) throw Native.Error(status, "");
    return (Status)status;
  }
  static void RequireLengths(int n, int length, int lengthOfResults) {
    if (n < 0 || n > length || n > lengthOfResults)
      throw new ArgumentException("arrays of " + length + " and " + lengthOfResults + " elements do not have " + n);
  }
}

/// phn_loop_settings: SI units, values of Defaults in phynness_loop.h.
[StructLayout(LayoutKind.Sequential)]
public struct LoopSettings {
  public double Period, PositionResolution;
  public Vec3 RotationRow0, RotationRow1, RotationRow2, Origin;
  public double MotionScale, ForceScale;
  public double Coupling, CouplingDamping, DeviceDamping, Reach, LargestDamping, LeastMass, Allowance, LargestReserve;
  public double LargestForce, LargestSlew, Ramp;
  public double TripEnergy, TripForce, TripSpeed, TripJump, TripStale, TripFrozen, TripOverrun;
  int reserved0, reserved1;

  public static LoopSettings Defaults {
    get { Native.Require(Native.phn_loop_defaults(out LoopSettings settings), ""); return settings; }
  }
}

/// phn_loop_response: what the body does to the tool.
[StructLayout(LayoutKind.Sequential)]
public struct LoopResponse {
  public Status Status;
  int inContact, hasStiffness;
  public Vec3 Force, StiffnessRow0, StiffnessRow1, StiffnessRow2, Displacement;
  public double Energy;
  int reserved0, reserved1;
  public bool InContact { set { inContact = value ? 1 : 0; } }
  public bool HasStiffness { set { hasStiffness = value ? 1 : 0; } }
}

public enum LoopState { Off = 0, On = 1, Tripped = 2 }

/// phn_loop_report.
[StructLayout(LayoutKind.Sequential)]
public struct LoopReport {
  public LoopState State;
  public int Trip;
  public double Work, MostDelivered, Unsure, Dissipated, Speed, Age;
  public Vec3 Force;
  public long Cycles, Limited, Missing, Late;
  int reserved0, reserved1;
  public string TripMessage { get { return Native.Text(Native.phn_loop_trip_message(Trip)); } }
}

/// phn_loop: coupling, limits, passivity and trips between a device and a body. Positions [m], times [s], forces [N].
public sealed class Loop : IDisposable {
  readonly Block block;
  readonly Vec3[] at = new Vec3[1];

  public Loop(LoopSettings settings) {
    Native.RequireSize("phn_loop_settings", typeof(LoopSettings));
    Native.RequireSize("phn_loop_response", typeof(LoopResponse));
    Native.RequireSize("phn_loop_report", typeof(LoopReport));
    Native.Require(Native.phn_loop_size(out UIntPtr bytes), "");
    block = new Block(bytes);
    int refused = Native.phn_loop_init(block.Memory, bytes, ref settings, out block.Object);
    Native.Require(refused, Native.Text(Native.phn_loop_trip_message(refused)) + " ");
  }
  public void Engage() { Native.Require(Native.phn_loop_engage(block.Object), ""); }
  /// position: null if none arrived. tool: its position in the frame of the body.
  public Status Read(Vec3? position, double measured, double now, out Vec3 tool) {
    at[0] = position.GetValueOrDefault();
    return (Status)Native.phn_loop_read(block.Object, position.HasValue ? at : null, measured, now, out tool);
  }
  /// The force for the device; zeros while the loop is off or tripped.
  public Status Hold(ref LoopResponse response, double now, out Vec3 force) =>
    (Status)Native.phn_loop_hold(block.Object, ref response, now, out force);
  public LoopReport Report {
    get { Native.Require(Native.phn_loop_info(block.Object, out LoopReport report), ""); return report; }
  }
  public void Dispose() { block.Dispose(); }
}

/// Unmanaged memory with an object of the library in it, which needs no release of its own.
sealed class Block : IDisposable {
  public delegate int SizeOf(IntPtr of, int n, out UIntPtr bytes);
  public delegate int Init(IntPtr memory, UIntPtr bytes, IntPtr of, int n, out IntPtr made);
  public delegate int SizeOfText(byte[] text, UIntPtr length, out UIntPtr bytes, out UIntPtr wrongByte);
  public delegate int InitOfText(IntPtr memory, UIntPtr bytes, byte[] text, UIntPtr length, out IntPtr made,
                                 out UIntPtr wrongByte);
  public IntPtr Object;
  public IntPtr Memory { get; private set; }
  readonly UIntPtr bytes;

  public Block(UIntPtr bytes) {
    this.bytes = bytes;
    Memory = Marshal.AllocHGlobal(checked((IntPtr)(long)(ulong)bytes));
  }
  ~Block() { Dispose(); }
  public void Dispose() {
    Marshal.FreeHGlobal(Memory);
    Memory = Object = IntPtr.Zero;
    GC.SuppressFinalize(this);
  }
  public static Block Of(Block of, int n, SizeOf size, Init init) {
    Native.Require(size(of.Object, n, out UIntPtr bytes), "");
    var block = new Block(bytes);
    Native.Require(block.Restart(of, n, init), "");
    return block;
  }
  public int Restart(Block of, int n, Init init) { return init(Memory, bytes, of.Object, n, out Object); }
  public static Block OfFile(string file, SizeOfText size, InitOfText init) {
    byte[] text = File.ReadAllBytes(file);
    int status = size(text, (UIntPtr)text.Length, out UIntPtr bytes, out UIntPtr wrong);
    Native.Require(status, file + ", byte " + wrong + ": ");
    var block = new Block(bytes);
    Native.Require(init(block.Memory, bytes, text, (UIntPtr)text.Length, out block.Object, out wrong), file + ": ");
    return block;
  }
}

/// What threads share.
sealed class Files {
  public readonly Block Model, Body;
  /// Of a body alone what it shares with a model.
  public readonly Native.Info Info;
  public readonly Native.BodyContents BodyContents;
  public readonly Block Relaxation = new Block((UIntPtr)Marshal.SizeOf(typeof(Native.Relaxation)));
  /// Of the model's moving nodes among the body's nodes; -1: inside of the body.
  public readonly int[] Rows = new int[0];

  public Files(string model, string body) {
    Native.RequireLibrary();
    if (model != null) {
      Model = Block.OfFile(model, Native.phn_model_size, Native.phn_model_init);
      Native.Require(Native.phn_model_info(Model.Object, out Info), "");
      Marshal.StructureToPtr(Info.relaxation, Relaxation.Memory, false);
    }
    if (body == null) return;
    Body = Block.OfFile(body, Native.phn_body_size, Native.phn_body_init);
    Native.Require(Native.phn_body_info(Body.Object, out BodyContents), "");
    if (model == null) {
      Info = new Native.Info { output_nodes = BodyContents.nodes, n_output = BodyContents.n_nodes,
                               output_points = BodyContents.points, triangles = BodyContents.triangles,
                               n_triangles = BodyContents.n_triangles, has_energy = 1,
                               max_displacement_m = BodyContents.max_displacement_m };
      Marshal.StructureToPtr(BodyContents.relaxation, Relaxation.Memory, false);
      return;
    }
    string of = Native.Text(Info.mesh_hash), other = Native.Text(BodyContents.mesh_hash);
    if (of != "" && other != "" && of != other)
      throw Native.Error((int)Status.ErrorArgument, "the body of mesh " + other + ", the model of mesh " + of + ": ");
    int[] nodes = Native.Copy(BodyContents.nodes, BodyContents.n_nodes);
    Rows = Native.Copy(Info.output_nodes, Info.n_output);
    for (int i = 0; i < Rows.Length; ++i) Rows[i] = Math.Max(-1, Array.BinarySearch(nodes, Rows[i]));
  }
}

/// The C interface.
static class Native {
  public const int AbiVersion = 1, MostCoupled = 8;
  public const double NoBound = 1e300;
  const string library = "phynness", loop = "phynness_loop";

  [StructLayout(LayoutKind.Sequential)]
  public struct Provenance {
    public IntPtr mesh_hash, physics_hash, element, reference;
    public double shear_modulus_Pa, finer_mean, finer_p95, finer_tool_radius_m;
    public int finer_probes, finer_nodes, bound_reference, reserved;
  }
  [StructLayout(LayoutKind.Sequential)]
  public struct Relaxation {
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] g, tau_s;
    public double length_m;
    public int n_terms, reserved;
  }
  [StructLayout(LayoutKind.Sequential)]
  public struct Info {
    public IntPtr family, title, mesh_hash;
    public double max_displacement_m;
    public IntPtr active_nodes, output_nodes, fixed_nodes, output_points, fixed_points, triangles;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 16)] public IntPtr[] field_names_and_units;
    public int n_nodes, n_active, n_output, n_fixed, n_triangles, n_fields, n_levels, has_energy;
    public Provenance provenance;
    public Relaxation relaxation;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 4)] public int[] reserved;
  }
  [StructLayout(LayoutKind.Sequential)]
  public struct BodyContents {
    public IntPtr mesh_hash, physics_hash, law;
    public Relaxation relaxation;
    public double tool_radius_m, max_displacement_m;
    public IntPtr nodes, points, triangles;
    public int n_nodes, n_triangles, n_modes, n_pressures, n_cells, reserved;
  }
  [StructLayout(LayoutKind.Sequential)]
  public struct Coupled {
    public double residual, energy;
    public int reserved0, reserved1;
  }
  [StructLayout(LayoutKind.Sequential)]
  public struct BodyReport {
    public double energy, unbalanced, residual_m;
    public int steps, renewed, reserved0, reserved1;
  }

  [DllImport(library)] static extern int phn_abi_version();
  [DllImport(library)] static extern int phn_sizeof(string name);
  [DllImport(library)] static extern IntPtr phn_status_message(int status);
  [DllImport(library)] public static extern int phn_model_size(byte[] text, UIntPtr length, out UIntPtr bytes, out UIntPtr wrong);
  [DllImport(library)] public static extern int phn_model_init(IntPtr memory, UIntPtr bytes, byte[] text, UIntPtr length, out IntPtr model, out UIntPtr wrong);
  [DllImport(library)] public static extern int phn_model_info(IntPtr model, out Info info);
  [DllImport(library)] public static extern int phn_data_size(IntPtr model, int mostTools, out UIntPtr bytes);
  [DllImport(library)] public static extern int phn_data_init(IntPtr memory, UIntPtr bytes, IntPtr model, int mostTools, out IntPtr data);
  [DllImport(library)] public static extern int phn_nearest(IntPtr model, ref Vec3 x, out Tool tool, out Vec3 point, out double distance);
  [DllImport(library)] public static extern int phn_force(IntPtr model, IntPtr data, ref Tool tool, out Vec3 force, [Out] double[] energy, IntPtr stiffness);
  [DllImport(library)] public static extern int phn_deform(IntPtr model, IntPtr data, ref Tool tool, [Out] Vec3[] field);
  [DllImport(library)] public static extern int phn_bound(IntPtr model, ref Tool tool, [Out] double[] bound);
  [DllImport(library)] public static extern int phn_relax(IntPtr terms, ref Relaxing history, ref Vec3 elastic, ref Vec3 place, double dt, ref Vec3 force);
  [DllImport(library)] public static extern int phn_couple(IntPtr model, IntPtr data, int n, [In] Tool[] tools, [Out] Vec3[] forces, out Coupled coupled);
  [DllImport(library)] public static extern int phn_coupled_deform(IntPtr model, IntPtr data, [Out] Vec3[] field);
  [DllImport(library)] public static extern int phn_body_size(byte[] text, UIntPtr length, out UIntPtr bytes, out UIntPtr wrong);
  [DllImport(library)] public static extern int phn_body_init(IntPtr memory, UIntPtr bytes, byte[] text, UIntPtr length, out IntPtr body, out UIntPtr wrong);
  [DllImport(library)] public static extern int phn_body_info(IntPtr body, out BodyContents contents);
  [DllImport(library)] public static extern int phn_body_nearest(IntPtr body, ref Vec3 x, out Tool tool, out Vec3 point, out double distance);
  [DllImport(library)] public static extern int phn_body_state_size(IntPtr body, int mostTools, out UIntPtr bytes);
  [DllImport(library)] public static extern int phn_body_state_init(IntPtr memory, UIntPtr bytes, IntPtr body, int mostTools, out IntPtr state);
  [DllImport(library)] public static extern int phn_body_force(IntPtr body, IntPtr state, int n, [In] Tool[] tools, int steps, [Out] Vec3[] forces, out BodyReport report);
  [DllImport(library)] public static extern int phn_body_bound(IntPtr body, IntPtr state, int n, [Out] double[] bounds);
  [DllImport(library)] public static extern int phn_body_deform(IntPtr body, IntPtr state, [Out] Vec3[] field);
  [DllImport(library)] public static extern int phn_contact_size(IntPtr model, int mostTools, out UIntPtr bytes);
  [DllImport(library)] public static extern int phn_contact_init(IntPtr memory, UIntPtr bytes, IntPtr model, int mostTools, out IntPtr contact);
  [DllImport(library)] public static extern int phn_body_contact_size(IntPtr body, int mostTools, out UIntPtr bytes);
  [DllImport(library)] public static extern int phn_body_contact_init(IntPtr memory, UIntPtr bytes, IntPtr body, int mostTools, int steps, out IntPtr contact);
  [DllImport(library)] public static extern int phn_contact_step(IntPtr contact, int n, [In] Sphere[] spheres, [Out] Touch[] touches, out Report report);
  [DllImport(library)] public static extern int phn_contact_deform(IntPtr contact, [Out] Vec3[] field);
  [DllImport(library)] public static extern int phn_contact_reset(IntPtr contact);
  [DllImport(loop)] public static extern int phn_loop_defaults(out LoopSettings settings);
  [DllImport(loop)] public static extern int phn_loop_size(out UIntPtr bytes);
  [DllImport(loop)] public static extern int phn_loop_init(IntPtr memory, UIntPtr bytes, ref LoopSettings settings, out IntPtr made);
  [DllImport(loop)] public static extern int phn_loop_engage(IntPtr loop);
  [DllImport(loop)] public static extern int phn_loop_read(IntPtr loop, [In] Vec3[] position, double measured, double now, out Vec3 tool);
  [DllImport(loop)] public static extern int phn_loop_hold(IntPtr loop, ref LoopResponse response, double now, out Vec3 force);
  [DllImport(loop)] public static extern int phn_loop_info(IntPtr loop, out LoopReport report);
  [DllImport(loop)] public static extern IntPtr phn_loop_trip_message(int trip);

  public static void RequireLibrary() {
    RequireSame("the interface is", phn_abi_version(), AbiVersion);
    RequireSize("phn_tool", typeof(Tool));
    RequireSize("phn_contact_tool", typeof(Sphere));
    RequireSize("phn_contact_state", typeof(Touch));
    RequireSize("phn_contact_report", typeof(Report));
    RequireSize("phn_info", typeof(Info));
    RequireSize("phn_relaxing", typeof(Relaxing));
    RequireSize("phn_coupled", typeof(Coupled));
    RequireSize("phn_body_contents", typeof(BodyContents));
    RequireSize("phn_body_report", typeof(BodyReport));
  }
  public static void RequireSize(string name, Type type) =>
    RequireSame("the bytes of " + name + " are", phn_sizeof(name), Marshal.SizeOf(type));
  static void RequireSame(string what, int number, int own) {
    if (number != own)
      throw new PhynnessException(Status.ErrorVersion, what + " " + number + " in the library phynness and " + own +
                                  " in Phynness.cs: use both of one release");
  }
  public static void Require(int status, string where) { if (status < 0) throw Error(status, where); }
  public static PhynnessException Error(int status, string where) =>
    new PhynnessException((Status)status, where + Text(phn_status_message(status)));
  public static string Text(IntPtr utf8) {
    if (utf8 == IntPtr.Zero) return "";
    int n = 0;
    while (Marshal.ReadByte(utf8, n) != 0) ++n;
    var bytes = new byte[n];
    Marshal.Copy(utf8, bytes, 0, n);
    return Encoding.UTF8.GetString(bytes);
  }
  public static int[] Copy(IntPtr from, int n) {
    var numbers = new int[n];
    if (n > 0) Marshal.Copy(from, numbers, 0, n);
    return numbers;
  }
  public static Vec3[] Points(IntPtr from, int n) {
    var points = new Vec3[n];
    for (int i = 0; i < n; ++i) points[i] = (Vec3)Marshal.PtrToStructure(IntPtr.Add(from, 24 * i), typeof(Vec3));
    return points;
  }
}

}  // namespace Phynness
