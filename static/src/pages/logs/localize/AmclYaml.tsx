import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import type { JobParameters } from "../jobParameters";
import { amclYaml, readAmclYaml } from "./api";

/** The parameters from the yaml of an AMCL, and as one. */
export function AmclYaml({ parameters }: { readonly parameters: JobParameters }) {
  const input = useRef<HTMLInputElement>(null);
  const said = useSignal<{ readonly text: string; readonly isError: boolean } | null>(null);
  const doing = async (what: () => Promise<string | null>): Promise<void> => {
    try {
      const text = await what();
      said.value = text === null ? null : { text, isError: false };
    } catch (error) {
      const text = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
      said.value = { text, isError: true };
    }
  };
  const open = (file: File): Promise<void> =>
    doing(async () => {
      const { values, ignored } = await readAmclYaml(file);
      parameters.values.value = values;
      const count = Object.keys(values).length;
      const set = `${count} ${count === 1 ? "parameter differs" : "parameters differ"} from the first values.`;
      return ignored.length > 0 ? `${set} Of no use here: ${ignored.join(", ")}.` : set;
    });
  const save = (): Promise<void> =>
    doing(async () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(await amclYaml(parameters.changed()));
      link.download = "amcl.yaml";
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
      return null;
    });
  return (
    <div class="localize-yaml">
      <input
        ref={input}
        type="file"
        hidden
        accept=".yaml,.yml"
        aria-label="Yaml of an AMCL"
        onChange={(event) => {
          const field = event.currentTarget;
          const file = field.files?.[0];
          field.value = "";
          if (file) void open(file);
        }}
      />
      <Button kind="quiet" icon="upload" onClick={() => input.current?.click()}>
        Open an AMCL yaml
      </Button>
      <Button kind="quiet" icon="download" onClick={() => void save()}>
        Save as AMCL yaml
      </Button>
      {said.value && <p role={said.value.isError ? "alert" : "status"}>{said.value.text}</p>}
    </div>
  );
}
