interface SwitchProps {
  name: string;
  isOn: boolean;
  isDisabled?: boolean;
  onSwitch: (on: boolean) => void;
}

export function Switch({ name, isOn, isDisabled = false, onSwitch }: SwitchProps) {
  return (
    <button
      type="button"
      class="switch"
      role="switch"
      aria-checked={isOn}
      disabled={isDisabled}
      onClick={() => onSwitch(!isOn)}
    >
      <span>{name}</span>
      <span class="track" aria-hidden="true" />
    </button>
  );
}
