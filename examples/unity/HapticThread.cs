// A haptic device that touches an organ by a sphere, 1,000 times a second in a thread of its own, which keeps a processor
// busy: virtual coupling, limits and trips are those of Loop. No engine is needed; OrganView.cs draws it in Unity.
using System;
using System.Diagnostics;
using System.Threading;
using Phynness;

/// A device, in the frame of the mesh or, by settings of the loop, in one of its own [m, N]. Neither method waits.
public interface IHapticDevice {
  /// False: no new position arrived since the last call. After 10 ms without one the loop trips.
  bool Read(out Vec3 position);
  /// Until the next call.
  void Apply(Vec3 force);
}

public sealed class HapticThread : IDisposable {
  readonly Organ organ;
  readonly IHapticDevice device;
  readonly Loop loop;
  readonly Sphere[] spheres;
  readonly Touch[] touches = new Touch[1];
  readonly object latest = new object();
  readonly Stopwatch clock = Stopwatch.StartNew();
  Touch drawn;
  LoopReport report;
  Thread thread;
  volatile Exception fault;
  volatile bool isStopped;

  /// organ: used by this thread alone; give another one to what draws.
  public HapticThread(Organ organ, IHapticDevice device, double radius, double friction, LoopSettings settings) {
    this.organ = organ ?? throw new ArgumentNullException(nameof(organ));
    this.device = device ?? throw new ArgumentNullException(nameof(device));
    loop = new Loop(settings);
    loop.Engage();
    report = loop.Report;
    spheres = new[] { new Sphere { Radius = radius, Friction = friction, Mode = SphereMode.Press } };
  }

  public void Start() {
    if (thread != null) throw new InvalidOperationException("this thread was started before");
    thread = new Thread(Run) { IsBackground = true, Priority = ThreadPriority.Highest };
    thread.Start();
  }
  void Run() {
    double next = 0;
    try {
      while (!isStopped && report.State != LoopState.Tripped) {  // only this thread writes the report
        Cycle(clock.Elapsed.TotalSeconds);
        next = Math.Max(next + 1e-3, clock.Elapsed.TotalSeconds);
        while (clock.Elapsed.TotalSeconds < next) Thread.SpinWait(20);  // sleeping would take up to 15 ms
      }
    } catch (Exception thrown) {
      fault = thrown;  // a thread that threw would end the program
    }
    try { device.Apply(new Vec3()); } catch (Exception thrown) { fault = fault ?? thrown; }
  }

  /// One cycle. now [s]: of a monotonic clock.
  public void Cycle(double now) {
    bool arrived = device.Read(out Vec3 position);
    loop.Read(arrived ? position : (Vec3?)null, now, now, out Vec3 tool);
    spheres[0].Center = tool;
    var response = new LoopResponse { Energy = -1 };
    try {
      response.Status = organ.Touch(spheres, 1, touches, out Report made);
      response.Energy = organ.HasEnergy ? made.Energy : -1;
    } catch (PhynnessException error) {
      response.Status = error.Status;  // the loop trips, and its message says why
    }
    response.InContact = touches[0].InContact;
    response.Force = touches[0].Force;
    response.Displacement = touches[0].Held.Displacement;
    loop.Hold(ref response, now, out Vec3 force);
    device.Apply(force);
    lock (latest) {
      drawn = touches[0];
      report = loop.Report;
    }
  }

  /// What the device or the organ threw, which stopped the thread.
  public Exception Fault { get { return fault; } }
  /// For the thread that draws: the state of the loop, whose TripMessage says why it stopped, and the touched place.
  public LoopReport Latest(out Touch touch) {
    lock (latest) {
      touch = drawn;
      return report;
    }
  }

  public void Dispose() {
    isStopped = true;
    if (thread != null) thread.Join();
    loop.Dispose();
  }
}
