import { Terminal } from "../../lessons/pipeline/Terminal";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

export function CharactersSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="characters" label="The map as characters">
          <Terminal />
        </OnStage>
      }
      sources={[]}
    >
      <p>
        A map can be printed in a terminal, one character for each cell. There are either three <b>states</b>: more
        likely occupied than the prior, less likely, or undecided, with a margin of 0.5 in the log-odds; or six steps of{" "}
        <b>density</b>, in which a darker character means a higher probability.
      </p>
    </Section>
  );
}
