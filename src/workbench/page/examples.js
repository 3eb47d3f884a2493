// What a new script starts from. Both are whole: they check without a problem.

export const EXAMPLES = {
  effect: `// Friction that grows with the square of the speed: change it to what your robot does.
fn about() {
    #{
        title: "friction that grows with the square of the speed",
        text: "Air and grease that are pushed around resist with the square of the speed.",
        equation: "tau_j = fq_j dq_j |dq_j|",
        // One symbol per fitted number; \`min\` and \`max\` say what can be physics.
        parameters: [#{ symbol: "fq", unit: "N m s^2/rad^2", meaning: "torque at 1 rad/s", min: 0.0 }],
    }
}

// What torque one unit of each parameter makes. \`now\` has t, dt, q, dq, dq_sharp, ddq, load.
fn columns(joint, now, memory, with) {
    let v = now.dq_sharp;
    [ v * abs(v) ]
}
`,
  constraint: `// The moving links together weigh between two values: change it to what you know.
fn settings() {
    #{ min: 10.0, max: 25.0 }    // kg
}

// A link has name, mass [kg], com [m], inertia [kg m^2]. The last line says what must hold.
fn constrain(robot, links, with) {
    let mass = total_mass(links);
    [ mass >= with.min, mass <= with.max ]
}
`,
};
