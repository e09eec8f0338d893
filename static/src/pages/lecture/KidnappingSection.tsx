import { Prediction } from "../../lessons/common/Prediction";
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
      predict={
        <Prediction
          text="The robot was carried away four scans ago, as in the first state of the figure. After how many more scans is most of the belief within half a metre of it?"
          axis={{ low: 0, high: 60, unit: "scans" }}
          step={1}
          reveal={async () => (await import("../../lessons/localization/foundAgain")).foundAgain()}
        />
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
            α_slow: with equal rates no particle is ever added. Here w is the n-th root of the product over the n beams;
            the product itself changes by orders of magnitude from scan to scan.
          </p>
          <p>
            In AMCL both rates are 0 by default, and it does not recover; its documentation suggests 0.001 and 0.1. A
            sensor that is blocked for a while also gives poor weights: if the reaction is too strong, it scatters
            particles that were right.
          </p>
        </>
      }
    >
      <p>
        Once the particles have converged, they cannot find a robot that is somewhere else: resampling draws only from
        poses that are already there. The <b>kidnapped robot problem</b> tests this: the robot is carried away without
        being told. From a slow and a fast average of the weights, <b>augmented MCL</b> detects that the scans fit worse
        than before, and replaces a share of the particles by random poses. Once one of them is near the robot,
        resampling concentrates the particles there. Press “Drive on”, and kidnap the robot again.
      </p>
    </Section>
  );
}
