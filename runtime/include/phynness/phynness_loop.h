/* phynness: the part of a haptic controller between a device and a body.
 *
 * One cycle: read the device; phn_loop_read gives the position of the tool; phn_force, phn_couple or phn_contact_step
 * gives the response of the body there; phn_loop_hold gives the force for the device. The library contains the virtual
 * coupling between device and tool, the transform between their frames, a passivity observer and controller, limits of
 * force and slew rate, and a trip that switches the force off and keeps it off. It does not depend on a model and may
 * be used with any other source of forces. docs/howto/haptic-loop.md explains it.
 *
 * The caller provides the memory. No function allocates memory, prints, or reads a clock or a file. A phn_loop belongs
 * to one thread. Units are SI. Functions that return int return a status of phynness.h. All outputs are finite.
 *
 * Frames: x_body = origin_m + motion_scale * rotation * x_device. A force of the body acts on the device as
 * force_scale * rotation^T * force. Positions, velocities, forces and energies are those of the device unless a comment
 * says otherwise. An energy is positive if the loop takes it from the device.
 *
 * Time: `now_s` and `measured_s` are those of one monotonic clock of the caller [s]. A force acts from its
 * phn_loop_hold until the next one: if the device applies it later by a known time, take this time off from every
 * measured_s.
 *
 * The passivity observer adds up -force . displacement for the forces that the device held between two positions, and
 * so knows the energy up to the newest position. Passivity observer and controller: Hannaford & Ryu 2002
 * (doi 10.1109/70.988969). */
#ifndef PHYNNESS_LOOP_H
#define PHYNNESS_LOOP_H

#include <phynness/phynness_api.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_loop phn_loop;

/* [Values of phn_loop_defaults]. A limit of 0 is not checked. */
typedef struct phn_loop_settings {
  double period_s;              /* of a cycle [1e-3] */
  double position_resolution_m; /* step of the measured positions [0] */

  double rotation[9];  /* proper rotation, row by row, correct to 1e-9 [identity] */
  double origin_m[3];  /* position of the device's origin in the body frame [0, 0, 0] */
  double motion_scale; /* metres of the body per metre of the device, > 0 [1] */
  double force_scale;  /* newtons at the device per newton of the body, > 0 [1] */

  double coupling_N_per_m;          /* stiffness of the virtual coupling, at the device [400] */
  double coupling_damping_Ns_per_m; /* for the velocity of the device relative to the tool [0.2] */
  double device_damping_Ns_per_m;   /* damping that the device certainly has; dissipation that may be used [0] */
  double reach_m;                   /* largest displacement of the body, body frame; 0: no limit [0] */
  double largest_damping_Ns_per_m;  /* of the passivity controller [2] */
  double least_mass_kg;     /* smallest apparent mass of device and hand; bounds forces before a reversal [0.05] */
  double allowance_J;       /* energy that the loop may deliver in all before the controller acts [2e-5] */
  double largest_reserve_J; /* energy beyond the stored energy that may be returned later [5e-4] */

  double largest_force_N;      /* a longer force is shortened [8] */
  double largest_slew_N_per_s; /* rate of change of the force [4000] */
  double ramp_s;               /* of the force after phn_loop_engage [0.1] */

  double trip_energy_J;          /* delivered by the loop beyond what it took and device_damping dissipated [3e-4] */
  double trip_force_N;           /* of the coupling before all limits [40] */
  double trip_speed_m_per_s;     /* of the device, over 4 positions [2] */
  double trip_jump_m;            /* between two positions one period apart [0.01] */
  double trip_stale_s;           /* age of the newest position [0.01] */
  double trip_frozen_s;          /* no change by one bit after a motion of more than 20 mm/s [0.05] */
  double trip_overrun_s;         /* between two calls of phn_loop_hold [0.02] */
  int32_t reserved[2] PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_loop_settings;
PHN_API int phn_loop_defaults(phn_loop_settings* settings);

enum { /* phn_loop_report.state */ PHN_LOOP_OFF = 0, PHN_LOOP_ON = 1, PHN_LOOP_TRIPPED = 2 };
enum { /* phn_loop_report.trip */
       PHN_TRIP_NONE = 0,
       PHN_TRIP_ENERGY = 1,
       PHN_TRIP_FORCE = 2,
       PHN_TRIP_SPEED = 3,
       PHN_TRIP_JUMP = 4,
       PHN_TRIP_STALE = 5,
       PHN_TRIP_FROZEN = 6,
       PHN_TRIP_OVERRUN = 7,
       PHN_TRIP_NOT_FINITE = 8, /* a position beyond 1000 m, or one or a response of the body is NaN or infinite */
       PHN_TRIP_CLOCK = 9,      /* now_s does not advance from cycle to cycle, or measured_s is later than now_s */
       PHN_TRIP_BODY = 10       /* the response of the body was refused: status < 0 in phn_loop_response */
};
/* The reason of a trip, or the setting that phn_loop_init refused, in one sentence; never null. */
PHN_API const char* phn_loop_trip_message(int trip);

/* Memory of a loop [bytes], and a loop in this memory, which is switched off; again after a trip.
 * PHN_ERROR_ARGUMENT: a null pointer. PHN_ERROR_SETTING - i: member i of the settings, from period_s = 0, is out of its
 * range, NaN or infinite; phn_loop_trip_message(status) names it. */
PHN_API int phn_loop_size(size_t* bytes);
PHN_API int phn_loop_init(void* memory, size_t bytes, const phn_loop_settings* settings, phn_loop** loop);

/* Switches the loop on; its force rises from zero. PHN_ERROR_ARGUMENT: the loop is tripped. */
PHN_API int phn_loop_engage(phn_loop* loop);

/* Begins a cycle. `position_m` is the newest position of the device, measured at `measured_s`, or null if none arrived.
 * Late, repeated and reordered positions are recognized by their times; a lost one is bridged with constant velocity.
 * `tool` is the position of the tool in the body frame, for which the caller computes the response of the body. */
PHN_API int phn_loop_read(phn_loop* loop, const double position_m[3], double measured_s, double now_s, double tool[3]);

/* Response of the body to the tool, body frame. */
typedef struct phn_loop_response {
  int32_t status;                /* of the function that computed it; < 0 trips the loop */
  int32_t in_contact;            /* 0: the body is not touched, and the tool follows the device without force */
  int32_t has_stiffness;         /* 0: the secant stiffness force . displacement / |displacement|^2 is used */
  double force[3];               /* on the body [N] */
  double stiffness[9];           /* its derivative [N/m], symmetric; may be indefinite */
  double displacement[3];        /* of the held point of the body from its rest position [m] */
  double energy;                 /* stored [J]; < 0: not known */
  int32_t reserved[2] PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_loop_response;

/* Ends a cycle: moves the tool by one Newton step towards the balance of body and coupling, and gives the force for the
 * device [N]. Zeros while the loop is off or tripped. */
PHN_API int phn_loop_hold(phn_loop* loop, const phn_loop_response* response, double now_s, double force[3]);

typedef struct phn_loop_report {
  int32_t state, trip;     /* PHN_LOOP_*, PHN_TRIP_* */
  double work_J;           /* taken from the device since phn_loop_engage, up to the newest position */
  double most_delivered_J; /* largest value of -work_J so far */
  double unsure_J;         /* bound of the error of work_J by lost positions and by steps of the positions at rest */
  double dissipated_J;     /* lower bound of what device_damping_Ns_per_m dissipated */
  double speed_m_per_s;    /* of the device */
  double age_s;            /* of the newest position at the last phn_loop_read */
  double force_N[3];       /* last force */
  int64_t cycles, limited; /* all; those in which the passivity controller changed the force */
  int64_t missing, late;   /* cycles without a position; positions that were not newer than the last */
  int32_t reserved[2] PHN_ZEROS;
} phn_loop_report;
PHN_API int phn_loop_info(const phn_loop* loop, phn_loop_report* report);

/* A force for a device whose host may lose an answer, without a phn_loop, which has this in its trips. A call that was
 * refused, a thread that was late, a message that did not arrive: neither zero at once, which lets the hand fall
 * through, nor the last force for ever is right. The last answer is held for 10 ms and then lowered to zero in 100 ms;
 * when answers come again, the force rises to them in the same way. Begin with {0} and call it in every cycle.
 *
 * `answer` [N] is the new force, or null if there is none; `now_s` that of a monotonic clock. PHN_ERROR_CLOCK: now_s is
 * not later than in the call before, and PHN_ERROR_NOT_FINITE: an answer is not finite and counts as none; `force` is
 * then still the one to render, not zeros. */
typedef struct phn_bridge {
  double answer[3];
  double answered_s, now_s;
  double part; /* of the answer that is rendered */
  int32_t is_running;
  int32_t reserved PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_bridge;
PHN_API int phn_bridge_force(phn_bridge* bridge, const double answer[3], double now_s, double force[3]);

#ifdef __cplusplus
}
#endif

#endif
