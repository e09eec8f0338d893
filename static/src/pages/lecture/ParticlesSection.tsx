import { LaterFigure, LaterMore } from "./LaterFigure";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

export function ParticlesSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="particles" />}
      sources={[
        [
          "probabilistic-robotics",
          "tables 8.1 and 8.2 for the two beliefs, table 4.4 for the low-variance sampler, table 8.4 for KLD sampling",
        ],
        ["dellaert", ""],
      ]}
      after={
        <>
          <p>
            The wheel has one sector for each particle, as wide as its weight. The <b>low-variance sampler</b> puts all
            pointers on it at equal distances, turned by one random number r: drag the pointer with the handle. A
            particle of weight w is then drawn Mw times, rounded down or up, of M draws in all. With independent draws
            the numbers vary more, and particles that are equally good are lost by chance: choose “independent” and
            press the button a few times.
          </p>
          <p>
            <b>N_eff</b> = 1 / Σ w² says how many particles the weights amount to. Resampling makes the weights equal
            again and the set less varied; where N_eff is large, it can be left out.
          </p>
          <p>
            How many particles does a belief need? <b>KLD sampling</b> counts the bins with a particle in them. With n
            particles for k bins, the Kullback-Leibler distance between the particles and the belief is below ε, with
            the probability that belongs to the quantile z. While nothing is known, many bins are occupied and many
            particles are needed; once the robot is found, few bins and few particles. Go on with the steps above and
            watch k; drag ε and z on the curve.
          </p>
          <LaterMore id="particles" />
        </>
      }
    >
      <p>
        Up to here the poses were known, and the map was not. Now the map is given, and the pose is not. Where the robot
        may be is a <b>belief</b>, a distribution over poses. <b>Monte Carlo localization</b> represents it by a set of{" "}
        <b>particles</b>: poses, of which more are where the belief is higher. A reading gives each particle the weight
        p(z | x, m); new particles are drawn by these weights; then each moves as the odometry says, with its own error.
        The corridor has three doors that look alike. Go through the steps: after the second door one group is left. How
        a map and a pose give the weight is the subject of <SectionLink to="sensor-models" />.
      </p>
    </Section>
  );
}
