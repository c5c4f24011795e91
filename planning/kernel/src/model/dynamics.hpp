// InverseDynamics: joint torques and forces of a group's motion by the recursive Newton-Euler algorithm (Featherstone,
// "Rigid Body Dynamics Algorithms", 2008, 5.3), in the world's axes.
#pragma once

#include <vector>

#include "model/tree.hpp"

namespace wayproof {

// Mass distribution of a link L.
struct Inertia {
  double mass = 0;
  Vec3 center;                                     // p_LLcm
  Mat3 about_center{{0, 0, 0, 0, 0, 0, 0, 0, 0}};  // rotational inertia about the centre of mass, in L
};

class InverseDynamics {
 public:
  // `inertias`: of all links. `rotors`: reflected inertias of motors by velocity of the tree. Gravity is in W.
  InverseDynamics(const Tree& tree, Group group, std::vector<Inertia> inertias, std::vector<double> rotors,
                  Vec3 gravity);

  std::size_t num_positions() const { return group_.positions.size(); }
  std::size_t num_velocities() const { return group_.velocities.size(); }

  // Motion of a link's origin, and what its joint transmits to it about that origin, all in W.
  struct State {
    Vec3 w, alpha, a;
    Vec3 force, moment;
  };

  // Turning rate, and velocity of what is at the world's origin; also a moment about it and a force.
  struct Twist {
    Vec3 turn, shift;
  };

  // One coordinate of a joint that moves.
  struct Coordinate {
    int velocity, parent;        // index in the full v; the coordinate before it, -1: none
    Twist axis;                  // motion per rate
    Twist carried, accelerated;  // rates of the axis by what carries the joint: v x S, a x S + v x (v x S)
    Twist v, a;                  // of what it moves
  };

  // What a coordinate moves: masses, momenta and the wrench that accelerates it.
  struct Composite {
    double mass = 0;
    Vec3 moment;         // mass times centre
    Mat3 inertia, curl;  // about the world's origin; see dynamics_derivatives.cpp
    Vec3 linear;         // momentum
    Twist wrench;
  };

  // What one thread computes in.
  struct Work {
    std::vector<double> q, v, vdot, tau;
    std::vector<Transform> X_WL;
    std::vector<Mat3> R_WF;  // of each joint's fixed frame
    std::vector<State> states;
    std::vector<Coordinate> coordinates;
    std::vector<Composite> composites;  // of each coordinate
    std::vector<int> last_coordinate;   // of each link's joint, or of those before it
    std::vector<double> slopes;
  };

  Work work() const;

  // tau = M(q) vdot + C(q, v) v - tau_g(q), the group's; a follower's effort adds to its leader's by the transpose of
  // their coupling. All other joints rest.
  void efforts(const double* q, const double* v, const double* vdot, double* tau, Work& work) const;

  // Derivatives of tau by q, v and vdot, [3][nv][nv]; not for joints that float.
  void derivatives(const double* q, const double* v, const double* vdot, double* found, Work& work) const;

 private:
  void place(const double* q, Work& work) const;
  void efforts_here(const double* v, const double* vdot, double* tau, Work& work) const;
  void spread(const double* rates, std::vector<double>& full) const;
  void move(std::size_t i, Work& work) const;
  void load(std::size_t i, Work& work) const;
  void collect(std::size_t i, Work& work) const;
  void add_coordinates(std::size_t i, Work& work) const;
  void gather(std::vector<double>& by, double* found) const;

  Tree tree_;
  Group group_;
  std::vector<Inertia> inertias_;
  std::vector<double> rotors_;
  State world_;
};

}  // namespace wayproof
