import { signal } from "@preact/signals";
import { Independence } from "../../../lessons/independence/Independence";
import type { SensorParameters } from "../../../lessons/independence/model";
import { DragNumber } from "../../../ui/DragNumber";
import { BayesRule, MapProduct } from "../formulas";
import { Section, type SectionHead, SectionLink } from "../Section";

const sensor = signal<SensorParameters>({ prior: 0.2, sonarError: 0.05, beamError: 0.1 });

const set = (name: keyof SensorParameters) => (percent: number) => {
  sensor.value = { ...sensor.peek(), [name]: percent / 100 };
};

export function GridSection(head: SectionHead) {
  const { prior, sonarError, beamError } = sensor.value;
  return (
    <Section
      {...head}
      figure={<Independence sensor={sensor} />}
      sources={["moravec-elfes", "elfes", ["probabilistic-robotics", "chapter 9"]]}
      after={
        <>
          <p>
            In the joint distribution <em>at least one</em> cell has probably caused the echo: with each cell that the
            beam passes, the probability of the others rises. In the grid it stays as it was.{" "}
            <span class="no-print">Press a cell to change what the narrow beam measured.</span>
          </p>
          <p>
            In return the map fits in memory: the joint distribution of 100 × 100 cells needs 2<sup>10000</sup> numbers,
            the grid 10,000. With narrow laser beams little is lost: few cells can have caused the same reading.
          </p>
        </>
      }
    >
      <p>
        An occupancy grid divides the floor into square cells and estimates whether each is occupied. It makes three
        assumptions.
      </p>
      <ol>
        <li>
          A cell is either <b class="noun-hit">occupied</b> or <b class="noun-miss">free</b>, as a whole.
        </li>
        <li>The world does not change while it is mapped.</li>
        <li>The cells are independent: knowing one says nothing about the others.</li>
      </ol>
      <p>
        Occupied is <i>p</i> = 1, free is <i>p</i> = 0. Before any reading cell <i>i</i> is occupied with the{" "}
        <b class="noun-prior">prior</b> probability <i>p</i>(<i>m</i>
        <sub>
          <i>i</i>
        </sub>
        ), usually 0.5. By the third assumption the probability of a whole map, given all readings <i>z</i>
        <sub>
          1:<i>t</i>
        </sub>{" "}
        and poses <i>x</i>
        <sub>
          1:<i>t</i>
        </sub>
        , is a product over its cells:
      </p>
      <MapProduct />
      <p>
        The poses, the robot’s positions and headings, are assumed known (until <SectionLink to="odometry" />
        ). The figure shows what the third assumption loses: walls are connected, and the grid ignores it.
      </p>
      <p>
        A <b class="noun-beam">sonar</b>, which measures by sound, has received an echo from somewhere on an arc of five
        cells. The prior probability of each cell was{" "}
        <DragNumber
          label="prior of a cell"
          sentence="Probability that a cell is occupied, before any reading."
          value={Math.round(100 * prior)}
          unit="%"
          tone="prior"
          low={5}
          high={50}
          step={1}
          onInput={set("prior")}
          after="."
        />{" "}
        The sonar is wrong in{" "}
        <DragNumber
          label="error of the sonar"
          sentence="How often the sonar reports an echo from an empty arc, or no echo from an occupied one."
          value={Math.round(100 * sonarError)}
          unit="%"
          tone="beam"
          low={1}
          high={30}
          step={1}
          onInput={set("sonarError")}
        />{" "}
        of its readings. Then a narrow beam, wrong in{" "}
        <DragNumber
          label="error of the narrow beam"
          sentence="How often the narrow beam is wrong about a cell."
          value={Math.round(100 * beamError)}
          unit="%"
          tone="beam"
          low={1}
          high={40}
          step={1}
          onInput={set("beamError")}
        />{" "}
        of its readings, <b class="noun-miss">passed</b> cells 1, 2 and 4. Bayes’ rule says what a reading <i>z</i> does
        to the probability of a map m:
      </p>
      <BayesRule />
      <p>
        In words: the <b class="noun-prior">prior</b>, times how likely the reading is with that map, divided by how
        likely it is at all. The figure applies it to each of the 32 possible maps as a whole (the{" "}
        <b>joint distribution</b>), and to each cell by itself (the grid).
      </p>
    </Section>
  );
}
