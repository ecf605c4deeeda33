"""PyTorch twins of the image networks, written from their papers under torchvision's names.

torchvision's own classes are not used, so that the scripts need torch alone; `state_dict` names and numbers are
the same. Global pools average whatever size is left.
"""

import torch
from torch import nn

from twins import DEEP, DEEPER, IMAGE, Twin


def pooled(x):
    return x.flatten(2).mean(2)


def conv_bn(inputs, outputs, kernel, stride=1, groups=1, activation=nn.ReLU6):
    """Convolution without bias, batch norm, activation: entries 0, 1 and 2."""
    conv = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)
    return nn.Sequential(conv, nn.BatchNorm2d(outputs), activation())


class InvertedResidual(nn.Module):
    def __init__(self, inputs, outputs, stride, expansion):
        super().__init__()
        wide = inputs * expansion
        layers = [conv_bn(inputs, wide, 1)] if expansion != 1 else []
        layers += [conv_bn(wide, wide, 3, stride, groups=wide), nn.Conv2d(wide, outputs, 1, bias=False), nn.BatchNorm2d(outputs)]
        self.conv = nn.Sequential(*layers)
        self.skip = stride == 1 and inputs == outputs

    def forward(self, x):
        return x + self.conv(x) if self.skip else self.conv(x)


def multiple_of_8(width):
    nearest = max(8, int(width + 4) // 8 * 8)
    return nearest + 8 if nearest < 0.9 * width else nearest


class MobileNetV2(nn.Module):
    """Sandler et al. 2018, Table 2."""

    ROWS = [(1, 16, 1, 1), (6, 24, 2, 2), (6, 32, 3, 2), (6, 64, 4, 2), (6, 96, 3, 1), (6, 160, 3, 2), (6, 320, 1, 1)]

    def __init__(self, classes=6, in_channels=3, width_mult=1.0, dropout=0.2, **_sizes):
        super().__init__()
        channels = multiple_of_8(32 * width_mult)
        layers = [conv_bn(in_channels, channels, 3, 2)]
        for expansion, outputs, repeats, stride in self.ROWS:
            outputs = multiple_of_8(outputs * width_mult)
            for i in range(repeats):
                layers.append(InvertedResidual(channels, outputs, 1 if i else stride, expansion))
                channels = outputs
        last = multiple_of_8(1280 * max(1.0, width_mult))
        self.features = nn.Sequential(*layers, conv_bn(channels, last, 1))
        self.classifier = nn.Sequential(nn.Dropout(dropout), nn.Linear(last, classes))

    def forward(self, x):
        return self.classifier(pooled(self.features(x)))


class Stream(nn.Module):
    """What a stream of `Split` has of its own: blocks 0 to 2, 17, 18 and the classifier of a MobileNetV2."""

    def __init__(self, whole):
        super().__init__()
        self.features = nn.ModuleDict({str(i): whole.features[i] for i in (0, 1, 2, 17, 18)})
        self.classifier = nn.ModuleDict({"1": whole.classifier[1]})

    def enter(self, x):
        y = self.features["2"](self.features["1"](self.features["0"](x)))
        dark = (x.flatten(2).amax(2) == x.flatten(2).amin(2)).all(1)
        return y * (~dark)[:, None, None, None]

    def leave(self, x):
        return self.classifier["1"](pooled(self.features["18"](self.features["17"](x))))


class Split(nn.Module):
    """Rouhafzay et al. 2021, section 7: two streams around shared blocks 3 to 16; two outputs."""

    def __init__(self, classes=6, in_channels=6, **_sizes):
        super().__init__()
        self.register_buffer("mean", torch.zeros(in_channels))
        self.register_buffer("std", torch.ones(in_channels))
        halves = [MobileNetV2(classes, in_channels // 2) for _ in range(2)]
        self.visual, self.tactile = map(Stream, halves)
        self.shared = nn.Module()
        self.shared.features = nn.ModuleDict({str(i): halves[0].features[i] for i in range(3, 17)})

    def forward(self, x):
        x = (x - self.mean[:, None, None]) / self.std[:, None, None]
        seen, felt = x.chunk(2, 1)
        x = self.visual.enter(seen) + self.tactile.enter(felt)
        for block in self.shared.features.values():
            x = block(x)
        return self.visual.leave(x), self.tactile.leave(x)


class Basic(nn.Module):
    """Two convolutions of 3."""

    expansion = 1

    def __init__(self, inputs, width, stride):
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(inputs, width, 3, stride, 1, bias=False), nn.BatchNorm2d(width)
        self.conv2, self.bn2 = nn.Conv2d(width, width, 3, 1, 1, bias=False), nn.BatchNorm2d(width)
        self.downsample = downsample(inputs, width, stride)

    def forward(self, x):
        y = self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x)))))
        return torch.relu(y + self.downsample(x))


def downsample(inputs, outputs, stride):
    if stride == 1 and inputs == outputs:
        return nn.Identity()
    return nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs))


class ResNet(nn.Module):
    """He et al. 2016, Table 1."""

    def __init__(self, block, groups, classes, in_channels=3, **_sizes):
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(in_channels, 64, 7, 2, 3, bias=False), nn.BatchNorm2d(64)
        channels = 64
        for g, (width, repeats) in enumerate(zip([64, 128, 256, 512], groups)):
            blocks = []
            for i in range(repeats):
                blocks.append(block(channels, width, 2 if g and i == 0 else 1))
                channels = width * block.expansion
            setattr(self, f"layer{g + 1}", nn.Sequential(*blocks))
        self.fc = nn.Linear(channels, classes)

    def forward(self, x):
        x = nn.functional.max_pool2d(torch.relu(self.bn1(self.conv1(x))), 3, 2, 1)
        return self.fc(pooled(self.layer4(self.layer3(self.layer2(self.layer1(x))))))


class Bottleneck(nn.Module):
    """Narrow 1x1, 3x3 with the stride, 1x1 four times as wide."""

    expansion = 4

    def __init__(self, inputs, width, stride):
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(inputs, width, 1, bias=False), nn.BatchNorm2d(width)
        self.conv2, self.bn2 = nn.Conv2d(width, width, 3, stride, 1, bias=False), nn.BatchNorm2d(width)
        self.conv3, self.bn3 = nn.Conv2d(width, 4 * width, 1, bias=False), nn.BatchNorm2d(4 * width)
        self.downsample = downsample(inputs, 4 * width, stride)

    def forward(self, x):
        y = torch.relu(self.bn1(self.conv1(x)))
        y = self.bn3(self.conv3(torch.relu(self.bn2(self.conv2(y)))))
        return torch.relu(y + self.downsample(x))


class AlexNet(nn.Module):
    """Krizhevsky 2014."""

    def __init__(self, classes=6, in_channels=3, hidden=4096, dropout=0.5, **_sizes):
        super().__init__()
        relu, pool = nn.ReLU, lambda: nn.MaxPool2d(3, 2)
        layers = [nn.Conv2d(in_channels, 64, 11, 4, 2), relu(), pool(), nn.Conv2d(64, 192, 5, padding=2), relu(), pool()]
        layers += [nn.Conv2d(192, 384, 3, padding=1), relu(), nn.Conv2d(384, 256, 3, padding=1), relu()]
        self.features = nn.Sequential(*layers, nn.Conv2d(256, 256, 3, padding=1), relu(), pool())
        self.avgpool = nn.AdaptiveAvgPool2d(6)
        layers = [nn.Dropout(dropout), nn.Linear(256 * 36, hidden), relu(), nn.Dropout(dropout), nn.Linear(hidden, hidden), relu()]
        self.classifier = nn.Sequential(*layers, nn.Linear(hidden, classes))

    def forward(self, x):
        return self.classifier(self.avgpool(self.features(x)).flatten(1))


class Vgg16(nn.Module):
    """Simonyan and Zisserman 2015, Table 1, column D."""

    def __init__(self, classes=3, in_channels=3, hidden=4096, dropout=0.5, **_sizes):
        super().__init__()
        layers = []
        for filters, convolutions in [(64, 2), (128, 2), (256, 3), (512, 3), (512, 3)]:
            for _ in range(convolutions):
                layers += [nn.Conv2d(in_channels, filters, 3, padding=1), nn.ReLU()]
                in_channels = filters
            layers.append(nn.MaxPool2d(2))
        self.features = nn.Sequential(*layers)
        self.avgpool = nn.AdaptiveAvgPool2d(7)
        layers = [nn.Linear(512 * 49, hidden), nn.ReLU(), nn.Dropout(dropout), nn.Linear(hidden, hidden), nn.ReLU(), nn.Dropout(dropout)]
        self.classifier = nn.Sequential(*layers, nn.Linear(hidden, classes))

    def forward(self, x):
        return self.classifier(self.avgpool(self.features(x)).flatten(1))


class DenseLayer(nn.Module):
    def __init__(self, inputs):
        super().__init__()
        self.norm1, self.conv1 = nn.BatchNorm2d(inputs), nn.Conv2d(inputs, 128, 1, bias=False)
        self.norm2, self.conv2 = nn.BatchNorm2d(128), nn.Conv2d(128, 32, 3, padding=1, bias=False)

    def forward(self, x):
        y = self.conv1(torch.relu(self.norm1(x)))
        return torch.cat([x, self.conv2(torch.relu(self.norm2(y)))], 1)


class Transition(nn.Module):
    def __init__(self, inputs):
        super().__init__()
        self.norm, self.conv = nn.BatchNorm2d(inputs), nn.Conv2d(inputs, inputs // 2, 1, bias=False)

    def forward(self, x):
        return nn.functional.avg_pool2d(self.conv(torch.relu(self.norm(x))), 2)


class DenseNet201(nn.Module):
    """Huang et al. 2017, Table 1."""

    def __init__(self, classes=3, in_channels=3, **_sizes):
        super().__init__()
        features = {"conv0": nn.Conv2d(in_channels, 64, 7, 2, 3, bias=False), "norm0": nn.BatchNorm2d(64), "relu0": nn.ReLU()}
        features["pool0"] = nn.MaxPool2d(3, 2, 1)
        channels = 64
        for block, layers in enumerate([6, 12, 48, 32], 1):
            names = {f"denselayer{i + 1}": DenseLayer(channels + 32 * i) for i in range(layers)}
            features[f"denseblock{block}"] = nn.Sequential()
            for name, layer in names.items():
                features[f"denseblock{block}"].add_module(name, layer)
            channels += 32 * layers
            if block < 4:
                features[f"transition{block}"] = Transition(channels)
                channels //= 2
        features["norm5"] = nn.BatchNorm2d(channels)
        self.features = nn.Sequential()
        for name, layer in features.items():
            self.features.add_module(name, layer)
        self.classifier = nn.Linear(channels, classes)

    def forward(self, x):
        return self.classifier(pooled(torch.relu(self.features(x))))


class BasicConv(nn.Module):
    def __init__(self, inputs, outputs, kernel, stride=1):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
        self.bn = nn.BatchNorm2d(outputs, eps=0.001)

    def forward(self, x):
        return torch.relu(self.bn(self.conv(x)))


class Inception(nn.Module):
    def __init__(self, inputs, one, three, five, after_pool):
        super().__init__()
        self.branch1 = BasicConv(inputs, one, 1)
        self.branch2 = nn.Sequential(BasicConv(inputs, three[0], 1), BasicConv(*three, 3))
        self.branch3 = nn.Sequential(BasicConv(inputs, five[0], 1), BasicConv(*five, 3))
        self.branch4 = nn.Sequential(nn.MaxPool2d(3, 1, 1, ceil_mode=True), BasicConv(inputs, after_pool, 1))

    def forward(self, x):
        return torch.cat([self.branch1(x), self.branch2(x), self.branch3(x), self.branch4(x)], 1)


class Auxiliary(nn.Module):
    def __init__(self, inputs, classes):
        super().__init__()
        self.conv = BasicConv(inputs, 128, 1)
        self.fc1, self.dropout, self.fc2 = nn.Linear(2048, 1024), nn.Dropout(0.7), nn.Linear(1024, classes)

    def forward(self, x):
        x = self.conv(nn.functional.adaptive_avg_pool2d(x, 4)).flatten(1)
        return self.fc2(self.dropout(torch.relu(self.fc1(x))))


class GoogLeNet(nn.Module):
    """Szegedy et al. 2015, Table 1; with `aux` three outputs."""

    ROWS = [
        ("3a", 192, 64, (96, 128), (16, 32), 32),
        ("3b", 256, 128, (128, 192), (32, 96), 64),
        ("4a", 480, 192, (96, 208), (16, 48), 64),
        ("4b", 512, 160, (112, 224), (24, 64), 64),
        ("4c", 512, 128, (128, 256), (24, 64), 64),
        ("4d", 512, 112, (144, 288), (32, 64), 64),
        ("4e", 528, 256, (160, 320), (32, 128), 128),
        ("5a", 832, 256, (160, 320), (32, 128), 128),
        ("5b", 832, 384, (192, 384), (48, 128), 128),
    ]

    def __init__(self, classes=6, in_channels=3, dropout=0.2, aux=False, **_sizes):
        super().__init__()
        self.conv1 = BasicConv(in_channels, 64, 7, 2)
        self.conv2, self.conv3 = BasicConv(64, 64, 1), BasicConv(64, 192, 3)
        for name, *sizes in self.ROWS:
            setattr(self, f"inception{name}", Inception(*sizes))
        if aux:
            self.aux1, self.aux2 = Auxiliary(512, classes), Auxiliary(528, classes)
        self.dropout = nn.Dropout(dropout)
        self.fc = nn.Linear(1024, classes)

    def forward(self, x):
        pool = lambda x, kernel=3: nn.functional.max_pool2d(x, kernel, 2, ceil_mode=True)  # noqa: E731
        x = pool(self.conv3(self.conv2(pool(self.conv1(x)))))
        x = pool(self.inception3b(self.inception3a(x)))
        first = self.inception4a(x)
        second = self.inception4d(self.inception4c(self.inception4b(first)))
        x = self.inception5b(self.inception5a(pool(self.inception4e(second), 2)))
        logits = self.fc(self.dropout(pooled(x)))
        return (logits, self.aux1(first), self.aux2(second)) if hasattr(self, "aux1") else logits


class ShuffleBlock(nn.Module):
    def __init__(self, inputs, outputs, stride):
        super().__init__()
        half = outputs // 2
        depthwise = lambda n: [nn.Conv2d(n, n, 3, stride, 1, groups=n, bias=False), nn.BatchNorm2d(n)]  # noqa: E731
        pointwise = lambda a: [nn.Conv2d(a, half, 1, bias=False), nn.BatchNorm2d(half), nn.ReLU()]  # noqa: E731
        self.branch1 = nn.Sequential(*depthwise(inputs), *pointwise(inputs)) if stride > 1 else nn.Sequential()
        self.branch2 = nn.Sequential(*pointwise(inputs if stride > 1 else half), *depthwise(half), *pointwise(half))

    def forward(self, x):
        left, right = (x, x) if len(self.branch1) else x.chunk(2, 1)
        joined = torch.cat([self.branch1(left), self.branch2(right)], 1)
        n, channels, rows, columns = joined.shape
        return joined.view(n, 2, channels // 2, rows, columns).transpose(1, 2).reshape(joined.shape)


class ShuffleNetV2(nn.Module):
    """Ma et al. 2018, Table 5, width 1."""

    def __init__(self, classes=20, in_channels=2, **_sizes):
        super().__init__()
        self.conv1 = conv_bn(in_channels, 24, 3, 2, activation=nn.ReLU)
        channels = 24
        for stage, (outputs, blocks) in enumerate([(116, 4), (232, 8), (464, 4)], 2):
            first = [ShuffleBlock(channels, outputs, 2)]
            setattr(self, f"stage{stage}", nn.Sequential(*first, *[ShuffleBlock(outputs, outputs, 1) for _ in range(blocks - 1)]))
            channels = outputs
        self.conv5 = conv_bn(channels, 1024, 1, activation=nn.ReLU)
        self.fc = nn.Linear(1024, classes)

    def forward(self, x):
        x = nn.functional.max_pool2d(self.conv1(x), 3, 2, 1)
        return self.fc(pooled(self.conv5(self.stage4(self.stage3(self.stage2(x))))))


def mnas_layers(inputs, outputs, kernel, stride, expansion):
    """Narrow to wide, depthwise, wide to narrow: convolutions 0, 3 and 6, batch norms after them."""
    wide = inputs * expansion
    norm = lambda n: nn.BatchNorm2d(n, momentum=0.0003)  # noqa: E731
    depthwise = nn.Conv2d(wide, wide, kernel, stride, kernel // 2, groups=wide, bias=False)
    first = [nn.Conv2d(inputs, wide, 1, bias=False), norm(wide), nn.ReLU(), depthwise, norm(wide), nn.ReLU()]
    return nn.Sequential(*first, nn.Conv2d(wide, outputs, 1, bias=False), norm(outputs))


class MnasBlock(nn.Module):
    def __init__(self, inputs, outputs, kernel, stride, expansion):
        super().__init__()
        self.layers = mnas_layers(inputs, outputs, kernel, stride, expansion)
        self.skip = stride == 1 and inputs == outputs

    def forward(self, x):
        return x + self.layers(x) if self.skip else self.layers(x)


class MnasNet(nn.Module):
    """Tan et al. 2019, MnasNet-B1, width 1."""

    STACKS = [(24, 3, 2, 3, 3), (40, 5, 2, 3, 3), (80, 5, 2, 6, 3), (96, 3, 1, 6, 2), (192, 5, 2, 6, 4), (320, 3, 1, 6, 1)]

    def __init__(self, classes=20, in_channels=2, dropout=0.2, **_sizes):
        super().__init__()
        layers = [nn.Conv2d(in_channels, 32, 3, 2, 1, bias=False), nn.BatchNorm2d(32, momentum=0.0003), nn.ReLU()]
        layers += [nn.Conv2d(32, 32, 3, 1, 1, groups=32, bias=False), nn.BatchNorm2d(32, momentum=0.0003), nn.ReLU()]
        layers += [nn.Conv2d(32, 16, 1, bias=False), nn.BatchNorm2d(16, momentum=0.0003)]
        channels = 16
        for outputs, kernel, stride, expansion, repeats in self.STACKS:
            blocks = []
            for i in range(repeats):
                blocks.append(MnasBlock(channels, outputs, kernel, 1 if i else stride, expansion))
                channels = outputs
            layers.append(nn.Sequential(*blocks))
        layers += [nn.Conv2d(320, 1280, 1, bias=False), nn.BatchNorm2d(1280, momentum=0.0003), nn.ReLU()]
        self.layers = nn.Sequential(*layers)
        self.classifier = nn.Sequential(nn.Dropout(dropout), nn.Linear(1280, classes))

    def forward(self, x):
        return self.classifier(pooled(self.layers(x)))


# Zhang et al. 2022: two fingers of 23 readings, 300 ticks, twenty outputs.
FINGERS = dict(classes=20, in_channels=2, height=23, width=300)
SMALL = dict(in_channels=3, height=61, width=47, classes=4)


def image(make, cases, classes, dropouts={}, tolerance=DEEPER, **more):  # noqa: B006
    """A network on pictures of 224x224 with the compared paper's classes; `more` are other sizes and the rate."""
    rate = more.pop("rate", 0.01)
    published = {"in_channels": 3, "height": 224, "width": 224, "classes": classes, **more}
    by_case = tolerance if callable(tolerance) else lambda settings: tolerance
    return Twin(make, published, [IMAGE], cases, dropouts, rate, by_case, is_brief=True)


def sized_deep(settings):
    """Deep where the case has sizes of its own, deeper at the published ones."""
    return DEEP if settings else DEEPER


TWINS = {
    "mobilenet-v2": image(
        MobileNetV2,
        [{}, dict(in_channels=1, height=47, width=70, width_mult=0.35, classes=4)],
        classes=6,
        dropouts={"classifier.0": "features.18.1/relu6/global_average_pool/dropout"},
        tolerance=sized_deep,
    ),
    # Its fixtures are those of scripts/fixtures/outputs.py: it has two outputs.
    "mobilenet-v2-split": image(Split, [], classes=6, in_channels=6),
    # SGDM diverges at the usual 0.01 without batch norm, here and in vgg16.
    "alexnet": image(
        AlexNet,
        [dict(in_channels=1, height=79, width=95, hidden=40, classes=4)],
        classes=6,
        dropouts={
            "classifier.0": "features.10/relu/max_pool/adaptive_average_pool/flatten/dropout",
            "classifier.3": "classifier.1/relu/dropout",
        },
        tolerance=DEEP,
        rate=1e-4,
    ),
    "vgg16": image(
        Vgg16,
        [dict(height=40, width=64, hidden=32)],
        classes=3,
        dropouts={"classifier.2": "classifier.0/relu/dropout", "classifier.5": "classifier.3/relu/dropout"},
        tolerance=DEEP,
        rate=1e-4,
    ),
    "resnet18": image(
        lambda **settings: ResNet(Basic, [2, 2, 2, 2], **settings),
        [{}, dict(height=64, width=64), dict(in_channels=2, height=23, width=300, classes=20)],
        classes=3,
        tolerance=sized_deep,
    ),
    "resnet50": image(lambda **settings: ResNet(Bottleneck, [3, 4, 6, 3], **settings), [dict(height=64, width=64)], classes=6),
    "densenet201": image(DenseNet201, [dict(in_channels=1, height=61, width=35, classes=4)], classes=3),
    "googlenet": image(
        GoogLeNet,
        [dict(height=64, width=80)],
        classes=6,
        dropouts={"dropout": "inception5b/global_average_pool/dropout"},
    ),
    "shufflenet-v2": image(ShuffleNetV2, [{}, SMALL], **FINGERS),
    "mnasnet1-0": image(
        MnasNet,
        [{}, SMALL],
        dropouts={"classifier.0": "layers.15/relu/global_average_pool/dropout"},
        **FINGERS,
    ),
}
