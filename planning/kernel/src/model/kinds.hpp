// Kinds: every enum that Python knows too, with the list of its members, from which both the enum and its binding come.
//
// Python has the names alone, never the numbers. A `switch` over one of these has a case for each member and no
// `default:`, so that the compiler (-Werror=switch) names every place that a new member has to be added to.
// Nothing of the standard library: the files that are compiled once per instruction set include this.
#pragma once

namespace wayproof {

// Convex shapes; sizes as in planning/kernel/shape.py.
#define WAYPROOF_SHAPE_KINDS(X) X(box) X(sphere) X(cylinder) X(capsule) X(ellipsoid) X(hull) X(half_space)
// Joints: fixed ones have no coordinates.
#define WAYPROOF_JOINT_KINDS(X) X(fixed) X(revolute) X(prismatic) X(planar) X(floating)
// Verdict on a configuration or a motion.
#define WAYPROOF_VERDICTS(X) X(free) X(colliding) X(unsure)
// How the proof of a motion ended; `static_pair`: a pair that nothing moves is too near.
#define WAYPROOF_OUTCOMES(X) X(proven) X(too_near) X(unproven) X(static_pair)
// Tolerance of R_GT: an angle up to a bound, the angle of one axis up to a bound, or any rotation.
#define WAYPROOF_FREEDOMS(X) X(ball) X(cone) X(free)

#define WAYPROOF_MEMBER(name) name,

enum class ShapeKind : int { WAYPROOF_SHAPE_KINDS(WAYPROOF_MEMBER) };
enum class JointKind : int { WAYPROOF_JOINT_KINDS(WAYPROOF_MEMBER) };
enum class Verdict : unsigned char { WAYPROOF_VERDICTS(WAYPROOF_MEMBER) };
enum class Outcome : int { WAYPROOF_OUTCOMES(WAYPROOF_MEMBER) };
enum class Freedom : int { WAYPROOF_FREEDOMS(WAYPROOF_MEMBER) };

#undef WAYPROOF_MEMBER

// Most coordinates of one joint, in q and in v: those of a floating one.
inline constexpr int max_joint_positions = 7, max_joint_velocities = 6;

}  // namespace wayproof
