"""A tiny LLaVA with random weights, made on the spot: it says nothing, but as a real one would."""

from __future__ import annotations

from pathlib import Path

_TEMPLATE = (
    "{% for m in messages %}<|im_start|>{{ m.role }}\n{% for c in m.content %}"
    "{% if c.type == 'image' %}<image>{% else %}{{ c.text }}{% endif %}{% endfor %}<|im_end|>\n{% endfor %}"
    "{% if add_generation_prompt %}<|im_start|>assistant\n{% endif %}"
)
_SPECIAL = ["<|endoftext|>", "<|im_start|>", "<|im_end|>", "<image>"]


def make(folder: Path) -> Path:
    """Save the model and its processor in a folder. Some 150,000 parameters."""
    import torch
    import transformers as t
    from tokenizers import Tokenizer, decoders, models, pre_tokenizers
    from tokenizers.trainers import BpeTrainer

    words = Tokenizer(models.BPE())
    words.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    words.decoder = decoders.ByteLevel()
    alphabet = pre_tokenizers.ByteLevel.alphabet()
    words.train_from_iterator([], BpeTrainer(vocab_size=300, special_tokens=_SPECIAL, initial_alphabet=alphabet))
    tokenizer = t.PreTrainedTokenizerFast(
        tokenizer_object=words, eos_token=_SPECIAL[2], pad_token=_SPECIAL[0], additional_special_tokens=_SPECIAL
    )
    size = {"intermediate_size": 64, "num_hidden_layers": 2, "num_attention_heads": 2}
    config = t.LlavaConfig(
        vision_config=t.CLIPVisionConfig(hidden_size=32, image_size=56, patch_size=14, projection_dim=32, **size),
        text_config=t.LlamaConfig(
            vocab_size=len(tokenizer),
            hidden_size=32,
            num_key_value_heads=2,
            max_position_embeddings=4096,
            eos_token_id=tokenizer.convert_tokens_to_ids(_SPECIAL[2]),
            pad_token_id=tokenizer.convert_tokens_to_ids(_SPECIAL[0]),
            **size,
        ),
        image_token_index=tokenizer.convert_tokens_to_ids("<image>"),
        image_seq_length=16,
        vision_feature_select_strategy="default",
        vision_feature_layer=-1,
    )
    torch.manual_seed(0)
    t.LlavaForConditionalGeneration(config).save_pretrained(folder)
    pictures = getattr(t, "CLIPImageProcessorPil", t.CLIPImageProcessor)
    t.LlavaProcessor(
        image_processor=pictures(size={"shortest_edge": 56}, crop_size={"height": 56, "width": 56}),
        tokenizer=tokenizer,
        patch_size=14,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
        chat_template=_TEMPLATE,
    ).save_pretrained(folder)
    return folder
