import { wallNoise, wallWindow } from "../../../lessons/stage/controls";
import { Button } from "../../../ui/Button";
import { bound } from "../../../ui/bound";
import { DragNumber } from "../../../ui/DragNumber";
import { Slider } from "../../../ui/Slider";
import { OnStage, Section, type SectionHead } from "../Section";

const PRESETS = [
  { name: "broken", noise: 0.05, window: 0 },
  { name: "thin", noise: 0.05, window: 0.15 },
  { name: "thick", noise: 0.05, window: 0.5 },
] as const;

export function WindowSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="window" label="A wall measured with noise, mapped with a window">
          <div class="actions no-print">
            {PRESETS.map(({ name, noise, window: w }) => (
              <Button
                key={name}
                pressed={wallNoise.value === noise && wallWindow.value === w}
                onClick={() => {
                  wallNoise.value = noise;
                  wallWindow.value = w;
                }}
              >
                {name}
              </Button>
            ))}
          </div>
          <div class="figure-controls no-print">
            <Slider
              label="Range noise σ"
              sentence="Standard deviation of the measured distance."
              {...bound(wallNoise)}
              initial={0.05}
              low={0}
              high={0.15}
              step={0.01}
              unit="m"
              tone="beam"
            />
            <Slider
              label="Hit window of the wall"
              sentence="Width of the zone around the reading that counts as hit."
              {...bound(wallWindow)}
              initial={0.15}
              low={0}
              high={0.8}
              step={0.05}
              unit="m"
              tone="hit"
            />
          </div>
        </OnStage>
      }
      sources={[["probabilistic-robotics", "chapter 6 and table 9.2"]]}
      after={
        <p>
          With cells of 5 cm and lidar noise of 1 to 2 cm the cell itself is the window: <i>w</i> = 0.
        </p>
      }
    >
      <p>
        A measured distance is never exact. The usual model is a Gaussian around the true distance <i>z</i>
        <sup>∗</sup>, with a standard deviation of{" "}
        <DragNumber
          label="noise of a range"
          sentence="Standard deviation of the measured distance."
          {...bound(wallNoise)}
          unit="m"
          tone="beam"
          low={0}
          high={0.15}
          step={0.01}
          after=":"
        />
      </p>
      <math display="block" class="lesson-formula">
        <mrow>
          <mrow>
            <mi>p</mi>
            <mo>(</mo>
            <mi class="noun-beam">z</mi>
            <mo>∣</mo>
            <msup>
              <mi>z</mi>
              <mo>∗</mo>
            </msup>
            <mo>)</mo>
          </mrow>
          <mo>=</mo>
          <mfrac>
            <mn>1</mn>
            <mrow>
              <mi>σ</mi>
              <msqrt>
                <mrow>
                  <mn>2</mn>
                  <mi>π</mi>
                </mrow>
              </msqrt>
            </mrow>
          </mfrac>
          <mspace width="0.2em" />
          <mi>exp</mi>
          <mrow>
            <mo>(</mo>
            <mo>−</mo>
            <mfrac>
              <msup>
                <mrow>
                  <mo>(</mo>
                  <mi class="noun-beam">z</mi>
                  <mo>−</mo>
                  <msup>
                    <mi>z</mi>
                    <mo>∗</mo>
                  </msup>
                  <mo>)</mo>
                </mrow>
                <mn>2</mn>
              </msup>
              <mrow>
                <mn>2</mn>
                <msup>
                  <mi>σ</mi>
                  <mn>2</mn>
                </msup>
              </mrow>
            </mfrac>
            <mo>)</mo>
          </mrow>
        </mrow>
      </math>
      <p>
        Nor is the direction exact, and a beam ends anywhere within a cell. So the hits of one wall fall into several
        cells, and a beam that overshoots passes through a cell that an earlier one hit. The{" "}
        <b class="noun-hit">window</b> <i>w</i> absorbs all three errors. One to three cells wide, it gives a thin and
        stable wall. With no window the wall is <b>broken</b>; with a wide one it is <b>thick</b> and narrows the doors.
      </p>
    </Section>
  );
}
