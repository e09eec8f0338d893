import { KldNumber } from "../formulas";
import { LaterFigure, LaterMore, Section, type SectionHead, SectionLink } from "../Section";

export function ParticlesSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="particles" />}
      sources={[["probabilistic-robotics", "tables 4.4, 8.1, 8.2 and 8.4"], "dellaert", "amcl"]}
      after={
        <>
          <p>
            The wheel has one sector for each particle, as wide as its weight. The <b>low-variance sampler</b> puts all
            pointers on it at equal distances, turned by one random number. Of M draws a particle gets M times its
            weight, rounded down or up. <b>Independent</b> draws vary more, and lose equally good particles by chance.
          </p>
          <p>
            <b>
              N<sub>eff</sub>
            </b>
            , one over the sum of the squared weights, is the number of particles that count. Where it is large,
            resampling can be left out.
          </p>
          <p>
            How many particles does a belief need? The more places it covers, the more: <b>KLD sampling</b> counts the
            bins with a particle in them. With M particles for B bins the Kullback-Leibler distance to the belief is
            below ε, with the probability that belongs to the quantile q of the normal distribution: q = 2.33 for 99 %.
          </p>
          <KldNumber />
          <p>
            In AMCL, Nav2’s localization, pf_z (kld_z in ROS 1) is this quantile itself, so its default of 0.99 means 84
            %: 296 particles for 24 bins and ε = 0.05, where 99 % needs 417.{" "}
            <span class="no-print">Step on above and watch B; drag ε and q.</span>
          </p>
          <LaterMore id="particles" />
        </>
      }
    >
      <p>
        Now the map is given, and the pose is not. Where the robot may be is a <b>belief</b>, a distribution over poses.{" "}
        <b>Monte Carlo localization</b> represents it by <b>particles</b>: poses, denser where the belief is higher. A
        reading gives each particle the weight p(z | x, m) (<SectionLink to="sensor-models" />
        ); new ones are drawn by these weights; then each moves by the odometry, with its own error. The corridor has
        three equal doors: after the second door only one group is left.
      </p>
    </Section>
  );
}
