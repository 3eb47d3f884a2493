// Time of Pinocchio's inverse dynamics, joint-torque regressor and inertia matrix, and its torques.
//
//   bench ROBOT.txt STATES.csv TORQUES.csv
//
// ROBOT.txt has one line per revolute joint about z of a serial arm, as Pinocchio itself read them from
// a URDF: placement in the parent (rotation row by row, translation), mass, centre of mass, inertia
// about it (row by row). STATES.csv has the columns q1..qn, dq1..dqn, ddq1..ddqn; the torques go to TORQUES.csv with 17
// significant digits, and one line per kernel to stdout: its name and ns per call (best of many rounds).

#include <chrono>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

static pinocchio::Model read_robot(const char* path) {
    using Row = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    std::ifstream file(path);
    pinocchio::Model model;
    std::vector<double> x(25);
    pinocchio::JointIndex parent = 0;
    while (true) {
        for (double& value : x) file >> value;
        if (!file) return model;
        const Eigen::Matrix3d rotation = Eigen::Map<const Row>(x.data());
        const Eigen::Matrix3d inertia = Eigen::Map<const Row>(x.data() + 16);
        const pinocchio::SE3 placement(rotation, Eigen::Vector3d(x[9], x[10], x[11]));
        const std::string name = "joint" + std::to_string(parent + 1);
        parent = model.addJoint(parent, pinocchio::JointModelRZ(), placement, name);
        const pinocchio::Inertia body(x[12], Eigen::Vector3d(x[13], x[14], x[15]), inertia);
        model.appendBodyToJoint(parent, body, pinocchio::SE3::Identity());
    }
}

struct State {
    Eigen::VectorXd q, dq, ddq;
};

static std::vector<State> read_states(const char* path, int n) {
    std::ifstream file(path);
    std::string line, cell;
    std::getline(file, line);
    std::vector<State> states;
    while (std::getline(file, line)) {
        std::istringstream cells(line);
        State state{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
        for (Eigen::VectorXd* part : {&state.q, &state.dq, &state.ddq})
            for (int j = 0; j < n; ++j) {
                std::getline(cells, cell, ',');
                (*part)[j] = std::stod(cell);
            }
        states.push_back(state);
    }
    return states;
}

// Keeps the compiler from dropping a result nobody reads.
static void keep(const void* result) { asm volatile("" : : "g"(result) : "memory"); }

template <class Work>
static void time_of(const char* name, const std::vector<State>& states, Work work) {
    using clock = std::chrono::steady_clock;
    double best = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 200; ++round) {
        const auto start = clock::now();
        for (const State& state : states) keep(&work(state));
        const std::chrono::duration<double, std::nano> taken = clock::now() - start;
        best = std::min(best, taken.count() / states.size());
    }
    std::cout << name << ' ' << best << '\n';
}

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: bench ROBOT.txt STATES.csv TORQUES.csv\n";
        return 2;
    }
    const pinocchio::Model model = read_robot(argv[1]);
    pinocchio::Data data(model);
    const std::vector<State> states = read_states(argv[2], model.nv);

    std::ofstream torques(argv[3]);
    torques << std::scientific << std::setprecision(16);
    for (const State& s : states) {
        const auto& tau = pinocchio::rnea(model, data, s.q, s.dq, s.ddq);
        for (int j = 0; j < model.nv; ++j) torques << (j ? "," : "") << tau[j];
        torques << '\n';
    }

    time_of("rnea", states, [&](const State& s) -> const auto& {
        return pinocchio::rnea(model, data, s.q, s.dq, s.ddq);
    });
    time_of("regressor", states, [&](const State& s) -> const auto& {
        return pinocchio::computeJointTorqueRegressor(model, data, s.q, s.dq, s.ddq);
    });
    time_of("mass_matrix", states, [&](const State& s) -> const auto& {
        return pinocchio::crba(model, data, s.q, pinocchio::Convention::WORLD);
    });
}
