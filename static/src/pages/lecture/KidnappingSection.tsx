import { LaterFigure } from "./LaterFigure";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

export function KidnappingSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="kidnapping" label="A robot that is carried away, and the particles that look for it">
          <LaterFigure id="kidnapping" />
        </OnStage>
      }
      sources={[
        ["probabilistic-robotics", "table 8.3"],
        ["amcl", "for recovery_alpha_slow and recovery_alpha_fast"],
      ]}
      after={
        <>
          <p>
            Each average follows the mean weight w of a scan’s particles: w_slow += α_slow (w − w_slow), and the same
            for w_fast. The share of random particles is max(0, 1 − w_fast / w_slow). α_fast has to be much larger than
            α_slow: with equal rates nothing is ever added. Here w is the n-th root of the product over the n beams; the
            product itself changes by orders of magnitude from scan to scan.
          </p>
          <p>
            In AMCL both rates are 0 at first, and it does not recover; 0.001 and 0.1 are the values that its
            documentation suggests. A robot whose sensor is blocked for a while also has poor weights: too large a
            reaction scatters a cloud that was right.
          </p>
        </>
      }
    >
      <p>
        A cloud of particles that has become small cannot find a robot that is somewhere else: where no particle is,
        none is drawn. The <b>kidnapped robot</b> is the test of this: it is carried away and not told.{" "}
        <b>Augmented MCL</b> notices that the scans fit worse than they used to, by a slow and a fast average of the
        weights, and replaces a share of the particles by random poses. One of them is near the robot sooner or later,
        and the cloud grows there. Press “Drive on”, and kidnap the robot again.
      </p>
    </Section>
  );
}
