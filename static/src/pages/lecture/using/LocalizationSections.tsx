/** Localization in a given map, each section with its scene. */

import { Prediction } from "../../../lessons/common/Prediction";
import { KldNumber } from "../formulas";
import { LaterFigure, LaterMore, OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function ParticlesSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<LaterFigure id="particles" />}
      sources={[["probabilistic-robotics", "tables 4.4, 8.1, 8.2 and 8.4"], "dellaert", "amcl"]}
      after={
        <>
          <p>
            The wheel has one sector for each particle, as wide as its weight; the weights add up to 1. The{" "}
            <b>low-variance sampler</b> puts all pointers on it at equal distances, turned by one random number. Of{" "}
            <i>M</i> draws a particle gets <i>M</i> times its weight, rounded down or up. <b>Independent</b> draws vary
            more, and lose equally good particles by chance.
          </p>
          <p>
            <b>
              <i>N</i>
              <sub>eff</sub>
            </b>
            , one over the sum of the squared weights, is the number of particles that count. Where it is large,
            resampling can be left out.
          </p>
          <p>
            How many particles? The more places the belief covers, the more: <b>KLD sampling</b> counts the bins with a
            particle in them. With <i>M</i> particles for <i>B</i> bins the Kullback-Leibler distance to the belief is
            below <i>ε</i> with probability 99 % if <i>q</i> = 2.33, the quantile of the normal distribution.
          </p>
          <KldNumber />
          <p>
            In AMCL, Nav2’s localization, pf_z (kld_z in ROS 1) is <i>q</i> itself: its default of 0.99 means 84 %, here
            296 particles in place of 417.{" "}
            <span class="no-print">
              Drag <i>ε</i> and <i>q</i>.
            </span>
          </p>
          <LaterMore id="particles" />
        </>
      }
    >
      <p>
        Now the map is given, and the pose is not. What the robot knows about its pose is a <b>belief</b>, a
        distribution over poses. <b>Monte Carlo localization</b> represents it by <b>particles</b>: poses, denser where
        the belief is higher. A reading gives each particle the weight <i>p</i>(<i>z</i> | <i>x</i>, <i>m</i>) (
        <SectionLink to="sensor-models" />
        ); new ones are drawn by these weights; then each moves by the odometry, with its own error (table 8.2 begins
        with the motion). The corridor has three equal doors: after the second door only one group is left.
      </p>
    </Section>
  );
}

export function SensorModelsSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<LaterFigure id="sensor-models" />}
      sources={[["probabilistic-robotics", "tables 6.1 and 6.3, sections 9.3 and 9.4"], "amcl"]}
      after={
        <>
          <p>
            Why can’t we get the inverse model from <i>p</i>(<i>z</i> | <i>x</i>, <i>m</i>) alone? It is a distribution
            over <b>readings</b>, for one whole map. A cell needs a distribution over its two <b>states</b>: Bayes’ rule
            also takes a prior, and sums over all maps in which the cell has that state.
          </p>
          <p>
            Some texts add log [<i>p</i>(<i>z</i> | <i>m</i>
            <sub>
              <i>i</i>
            </sub>
            ) / (1 − <i>p</i>(<i>z</i> | <i>m</i>
            <sub>
              <i>i</i>
            </sub>
            ))], as the dashed curve does, with the density scaled to at most 1. Bayes’ rule gives log [<i>p</i>(
            <i>z</i> | <i>m</i>
            <sub>
              <i>i</i>
            </sub>
            ) / <i>p</i>(<i>z</i> | ¬<i>m</i>
            <sub>
              <i>i</i>
            </sub>
            )]: how likely the reading is with the cell occupied, over how likely with it free. For a yes-or-no sensor
            with equal error rates both are the same. Otherwise the heuristic has the right sign before the reading and
            at it; programs leave out the cells behind it, and the clamp limits the error. The sum over all maps, exact
            here for one beam, is too costly on a plane: the model of <SectionLink to="model" /> is chosen by hand to
            have its shape. Section 9.4 of the book searches for the most probable map instead.
          </p>
          <p>
            The <b>likelihood field</b> on the stage replaces the ray by the distance from the end point to the nearest
            occupied cell: a table look-up, and smooth. It ignores that a wall hides what is behind it.
          </p>
        </>
      }
    >
      <p>
        A particle’s weight is <i>p</i>(<i>z</i> | <i>x</i>, <i>m</i>): <b>forwards</b>, from a map and a pose to the
        reading. The <b>beam model</b> has four parts: the range to the mapped surface, with noise; shorter ranges, from
        people and things that are not in the map; beams without a return; and random readings. The second chart is the{" "}
        <b>inverse</b> model: given one reading, which cells are occupied?
      </p>
    </Section>
  );
}

export function KidnappingSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="kidnapping" label="A robot that is carried away, and the particles that look for it">
          <LaterFigure id="kidnapping" />
        </OnStage>
      }
      predict={
        <Prediction
          text="The robot was carried away four scans ago. After how many more scans is most of the belief within half a metre of it?"
          axis={{ low: 0, high: 60, unit: "scans" }}
          step={1}
          reveal={async () => (await import("../../../lessons/localization/state")).foundAgain()}
        />
      }
      sources={[["probabilistic-robotics", "table 8.3"], "amcl"]}
      after={
        <>
          <p>
            Each average follows the mean weight of a scan’s particles at its own rate. The share of random particles is
            max(0, 1 − fast average / slow average). The fast rate has to be much larger: with equal rates no particle
            is ever added.
          </p>
          <p>In AMCL both rates are 0 by default, so it does not recover; its documentation suggests 0.001 and 0.1.</p>
        </>
      }
    >
      <p>
        Once the particles have converged, resampling draws only from poses that are there: a robot carried away without
        being told stays lost (the <b>kidnapped robot problem</b>). <b>Augmented MCL</b> compares a fast average of the
        weights with a slow one; where the scans fit worse than before, it replaces a share of the particles by random
        poses. <span class="no-print">Press “Drive on”, and kidnap the robot again.</span>
      </p>
    </Section>
  );
}
